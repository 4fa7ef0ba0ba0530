//! Decompression of Marc Lehmann's LZF, the compression of PCD files.

/// Decompresses `packed` to exactly `size` bytes.
///
/// # Errors
/// If `packed` is truncated, contains an invalid reference, or decompresses to more or fewer bytes. Memory grows only with the bytes
/// actually decompressed.
pub(super) fn unpack(packed: &[u8], size: usize) -> Result<Vec<u8>, String> {
    let mut out = Vec::new();
    let mut at = 0;
    let mut take = |count: usize| {
        let taken = packed.get(at..at + count);
        at += count;
        taken.ok_or_else(|| "the compressed data is cut".to_owned())
    };
    while let Ok(&[control]) = take(1) {
        let control = usize::from(control);
        if control < 32 {
            out.extend_from_slice(take(control + 1)?);
        } else {
            let mut length = (control >> 5) + 2;
            if length == 9 {
                length += usize::from(take(1)?[0]);
            }
            let back = ((control & 31) << 8) + usize::from(take(1)?[0]) + 1;
            let start =
                out.len().checked_sub(back).ok_or("the compressed data refers to what is not there")?;
            // the source of a copy may overlap its destination
            for i in start..start + length {
                out.push(out[i]);
            }
        }
        if out.len() > size {
            break;
        }
    }
    if out.len() == size {
        Ok(out)
    } else {
        Err(format!("the compressed data does not unpack to the {size} bytes that it announces"))
    }
}

/// Literal runs, and references for runs of one byte.
#[cfg(test)]
pub(super) fn pack(bytes: &[u8]) -> Vec<u8> {
    let mut packed = Vec::new();
    let mut rest = bytes;
    while let Some(&first) = rest.first() {
        let run = rest.iter().take_while(|&&b| b == first).count().min(200);
        if run > 12 {
            packed.extend([0, first, 7 << 5, u8::try_from(run - 1 - 9).unwrap(), 0]);
            rest = &rest[run..];
        } else {
            let (literal, after) = rest.split_at(rest.len().min(run.max(5)));
            packed.push(u8::try_from(literal.len() - 1).unwrap());
            packed.extend(literal);
            rest = after;
        }
    }
    packed
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn references_reach_into_their_own_copy() {
        // "ab", then nine bytes from two back, then three from one back
        assert_eq!(unpack(&[1, b'a', b'b', 7 << 5, 0, 1], 11).unwrap(), b"abababababa");
        assert_eq!(unpack(&[0, b'a', 1 << 5, 0], 4).unwrap(), b"aaaa");
        assert_eq!(unpack(&[], 0).unwrap(), b"");
    }

    #[test]
    fn broken_data_is_rejected() {
        for (packed, size) in [
            (&[1u8, b'a'][..], 2),
            (&[1 << 5, 0], 3),
            (&[0, b'a', 1 << 5, 1], 4),
            (&[0, b'a', 7 << 5], 9),
            (&[0, b'a'], 2),
            (&[1, b'a', b'b'], 1),
        ] {
            assert!(unpack(packed, size).is_err(), "{packed:?}");
        }
    }

    proptest! {
        #[test]
        fn what_is_packed_comes_back(bytes in prop::collection::vec(0u8..3, 0..400)) {
            prop_assert_eq!(unpack(&pack(&bytes), bytes.len()).unwrap(), bytes);
        }

        #[test]
        fn any_bytes_end_without_a_panic(packed in prop::collection::vec(any::<u8>(), 0..200), size in 0usize..500) {
            let _ = unpack(&packed, size);
        }
    }
}
