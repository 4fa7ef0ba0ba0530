//! Sets of cubes, such as the occupied leaves of an octree.

use super::point_cloud::is_near;
use crate::constants::LARGEST_COORDINATE;
use crate::math::{Point, Vector};

/// Solid cubes along the axes of their frame, of various sizes. Never empty.
#[derive(Clone, Debug, PartialEq)]
pub struct Voxels {
    cubes: Vec<Cube>,
}

/// All points that are no farther than `half_edge` (m) from `centre` along each axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cube {
    /// Centre (m).
    pub centre: [f32; 3],
    /// Half of the edge (m).
    pub half_edge: f32,
}

/// Reason why a list of cubes is not a valid set of voxels.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum VoxelsError {
    /// There are no cubes.
    #[error("there are no cubes")]
    NoCubes,
    #[error(
        "the centre of cube {cube} has a coordinate that is not finite or larger than {LARGEST_COORDINATE} m"
    )]
    /// A coordinate is not finite or larger than [`LARGEST_COORDINATE`].
    BadCentre {
        /// Index of the cube.
        cube: usize,
    },
    /// The edge is negative, not finite, or larger than [`LARGEST_COORDINATE`].
    #[error("half the edge of cube {cube} is not a number of metres from 0 to {LARGEST_COORDINATE:e}")]
    BadEdge {
        /// Index of the cube.
        cube: usize,
    },
    /// There are more cubes than 31 bits can number.
    #[error("there are {0} cubes, more than 31 bits can number")]
    TooManyCubes(usize),
}

impl Voxels {
    /// A set of cubes; rejects invalid input.
    pub fn new(cubes: Vec<Cube>) -> Result<Self, VoxelsError> {
        if cubes.is_empty() {
            return Err(VoxelsError::NoCubes);
        }
        if cubes.len() >> 31 != 0 {
            return Err(VoxelsError::TooManyCubes(cubes.len()));
        }
        if let Some(cube) = cubes.iter().position(|c| !is_near(&c.centre)) {
            return Err(VoxelsError::BadCentre { cube });
        }
        let usable = |c: &Cube| (0.0..=LARGEST_COORDINATE).contains(&f64::from(c.half_edge));
        match cubes.iter().position(|c| !usable(c)) {
            Some(cube) => Err(VoxelsError::BadEdge { cube }),
            None => Ok(Self { cubes }),
        }
    }

    /// All cubes, in the order given.
    #[must_use]
    pub fn cubes(&self) -> &[Cube] {
        &self.cubes
    }

    /// Smallest and largest corner of the box around all cubes.
    #[must_use]
    pub fn bounds(&self) -> (Point, Point) {
        let mut lo = Point::from([f64::INFINITY; 3]);
        let mut hi = Point::from([f64::NEG_INFINITY; 3]);
        for cube in &self.cubes {
            let centre = Point::from(cube.centre.map(f64::from));
            let half = Vector::repeat(f64::from(cube.half_edge));
            lo = lo.inf(&(centre - half));
            hi = hi.sup(&(centre + half));
        }
        (lo, hi)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faults_are_named() {
        let cube = |x: f32, half_edge: f32| Cube { centre: [x, 0.0, 0.0], half_edge };
        assert_eq!(Voxels::new(vec![]), Err(VoxelsError::NoCubes));
        assert_eq!(Voxels::new(vec![cube(f32::INFINITY, 1.0)]), Err(VoxelsError::BadCentre { cube: 0 }));
        assert_eq!(Voxels::new(vec![cube(0.0, 0.0), cube(0.0, -1.0)]), Err(VoxelsError::BadEdge { cube: 1 }));
    }
}
