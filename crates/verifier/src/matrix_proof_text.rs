//! Reads the text of a proof, a tree of halved boxes of joint positions, and verifies each of its leaves.

use clearance_geometry::math::Vector;

/// Largest number of nested halvings.
const DEEPEST: usize = 400;

/// Reads the text of a proof.
pub(super) struct ProofText<'p> {
    text: &'p [u8],
    /// Number of characters that were read.
    pub at: usize,
    /// Number of boxes that are proven.
    pub boxes: u64,
}

/// Evaluates the leaf of a character in the given ranges of the variables, and reads what belongs to it; `None` if there is no such leaf.
pub(super) type LeafTest<'p, 't> = dyn FnMut(u8, &mut ProofText<'p>, &[[f64; 2]]) -> Option<bool> + 't;

/// Reason why a tree of boxes is no proof, at the end of what was read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum BoxFault {
    Damaged,
    NotProven,
}

impl<'p> ProofText<'p> {
    pub fn new(text: &'p str) -> Self {
        Self { text: text.as_bytes(), at: 0, boxes: 0 }
    }

    /// Reads the whole text, and evaluates each leaf; returns the number of boxes.
    pub fn verify(&mut self, ranges: &[[f64; 2]], is_proven: &mut LeafTest<'p, '_>) -> Result<u64, BoxFault> {
        self.verify_box(&mut ranges.to_vec(), 0, is_proven)?;
        if self.at == self.text.len() { Ok(self.boxes) } else { Err(BoxFault::Damaged) }
    }

    fn verify_box(
        &mut self,
        ranges: &mut [[f64; 2]],
        depth: usize,
        is_proven: &mut LeafTest<'p, '_>,
    ) -> Result<(), BoxFault> {
        let first = self.next().filter(|_| depth <= DEEPEST).ok_or(BoxFault::Damaged)?;
        let Some(variable) = char::from(first).to_digit(36) else {
            self.boxes += 1;
            return match is_proven(first, self, ranges) {
                Some(true) => Ok(()),
                Some(false) => Err(BoxFault::NotProven),
                None => Err(BoxFault::Damaged),
            };
        };
        let variable = variable as usize;
        let [low, high] = *ranges.get(variable).ok_or(BoxFault::Damaged)?;
        let middle = low.midpoint(high);
        for half in [[low, middle], [middle, high]] {
            ranges[variable] = half;
            self.verify_box(ranges, depth + 1, is_proven)?;
        }
        ranges[variable] = [low, high];
        Ok(())
    }

    /// The next character.
    pub fn next(&mut self) -> Option<u8> {
        let byte = self.text.get(self.at).copied()?;
        self.at += 1;
        Some(byte)
    }

    /// The number of the next three digits of 6 bits.
    pub fn number(&mut self) -> Option<u32> {
        let mut number = 0;
        for _ in 0..3 {
            number = number << 6 | u32::from(value(self.next()?)?);
        }
        Some(number)
    }

    /// The direction of the next three digits: the centre of a cell of an octahedron's net of 512 × 512 cells.
    pub fn direction(&mut self) -> Option<Vector> {
        const CELLS: u32 = 512;
        let cell = self.number()?;
        let coordinate = |i: u32| (2.0 * f64::from(i) + 1.0) / f64::from(CELLS) - 1.0;
        let (x, y) = (coordinate(cell / CELLS), coordinate(cell % CELLS));
        let z = 1.0 - x.abs() - y.abs();
        // the lower half of the octahedron is folded outwards
        let fold = |c: f64, other: f64| if z < 0.0 { (1.0 - other.abs()).copysign(c) } else { c };
        Vector::new(fold(x, y), fold(y, x), z).try_normalize(0.0)
    }
}

fn value(digit: u8) -> Option<u8> {
    Some(match digit {
        b'0'..=b'9' => digit - b'0',
        b'A'..=b'Z' => digit - b'A' + 10,
        b'a'..=b'z' => digit - b'a' + 36,
        b'-' => 62,
        b'_' => 63,
        _ => return None,
    })
}
