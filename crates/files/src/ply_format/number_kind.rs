//! Number types of PLY, PCD and point cloud messages: size, byte order, and reading a number from bytes and text.

/// How a number is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NumberKind {
    /// 8-bit signed integer.
    I8,
    /// 8-bit unsigned integer.
    U8,
    /// 16-bit signed integer.
    I16,
    /// 16-bit unsigned integer.
    U16,
    /// 32-bit signed integer.
    I32,
    /// 32-bit unsigned integer.
    U32,
    /// 64-bit signed integer.
    I64,
    /// 64-bit unsigned integer.
    U64,
    /// 32-bit floating-point number.
    F32,
    /// 64-bit floating-point number.
    F64,
}

/// Which byte of a number comes first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ByteOrder {
    /// Least significant byte first.
    #[default]
    Little,
    /// Most significant byte first.
    Big,
}

impl NumberKind {
    /// Bytes of a number.
    #[must_use]
    pub fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    /// The number at the start of `bytes`; `None` when they are too few.
    #[allow(clippy::cast_precision_loss)] // no coordinate has more than 53 bits
    pub fn read(self, bytes: &[u8], order: ByteOrder) -> Option<f64> {
        macro_rules! number {
            ($kind:ty) => {{
                let bytes = bytes.first_chunk()?;
                match order {
                    ByteOrder::Little => <$kind>::from_le_bytes(*bytes),
                    ByteOrder::Big => <$kind>::from_be_bytes(*bytes),
                }
            }};
        }
        Some(match self {
            Self::I8 => number!(i8).into(),
            Self::U8 => number!(u8).into(),
            Self::I16 => number!(i16).into(),
            Self::U16 => number!(u16).into(),
            Self::I32 => number!(i32).into(),
            Self::U32 => number!(u32).into(),
            Self::I64 => number!(i64) as f64,
            Self::U64 => number!(u64) as f64,
            Self::F32 => number!(f32).into(),
            Self::F64 => number!(f64),
        })
    }

    /// A number as text; a 32-bit float is rounded once, as the program that wrote it would have it.
    pub fn parse(self, text: &str) -> Option<f64> {
        match self {
            Self::F32 => text.parse::<f32>().ok().map(f64::from),
            _ => text.parse().ok(),
        }
    }
}
