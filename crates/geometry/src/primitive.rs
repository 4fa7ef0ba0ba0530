//! Solid primitives: box, sphere, cylinder, cone, capsule.

use crate::constants::LARGEST_COORDINATE;
use crate::math::Point;

/// A solid primitive, centred on its own origin; the axis of cylinders, cones and capsules is z. Lengths in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Primitive {
    /// All points within the half extents.
    Box {
        /// Half of each edge (m).
        half_extents: [f64; 3],
    },
    /// All points within a radius of the origin.
    Sphere {
        /// Radius (m).
        radius: f64,
    },
    /// All points within a radius of the axis, between two discs.
    Cylinder {
        /// Radius (m).
        radius: f64,
        /// Half of the length along the axis (m).
        half_length: f64,
    },
    /// The disc lies at `-half_length`, the apex at `half_length`.
    Cone {
        /// Radius of the disc (m).
        radius: f64,
        /// Half of the height (m).
        half_length: f64,
    },
    /// `half_length` does not include the two half spheres.
    Capsule {
        /// Radius (m).
        radius: f64,
        /// Half of the length of the segment (m).
        half_length: f64,
    },
}

/// An invalid dimension of a solid.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{shape} {dimension} is {value}, but must be a number of metres from 0 to {LARGEST_COORDINATE:e}")]
pub struct PrimitiveError {
    /// Name of the kind of shape.
    pub shape: &'static str,
    /// Name of the dimension.
    pub dimension: &'static str,
    /// Rejected value (m).
    pub value: f64,
}

impl Primitive {
    /// A box with full edge lengths `size`.
    pub fn cuboid(size: [f64; 3]) -> Result<Self, PrimitiveError> {
        for value in size {
            check("box", "size", value)?;
        }
        Ok(Self::Box { half_extents: size.map(|s| 0.5 * s) })
    }

    /// A sphere of this radius (m).
    pub fn sphere(radius: f64) -> Result<Self, PrimitiveError> {
        check("sphere", "radius", radius)?;
        Ok(Self::Sphere { radius })
    }

    /// A cylinder of full `length`.
    pub fn cylinder(radius: f64, length: f64) -> Result<Self, PrimitiveError> {
        check("cylinder", "radius", radius)?;
        check("cylinder", "length", length)?;
        Ok(Self::Cylinder { radius, half_length: 0.5 * length })
    }

    /// A cone of full `length` over a disc of this radius, centred at half its height.
    pub fn cone(radius: f64, length: f64) -> Result<Self, PrimitiveError> {
        check("cone", "radius", radius)?;
        check("cone", "length", length)?;
        Ok(Self::Cone { radius, half_length: 0.5 * length })
    }

    /// A capsule; `length` does not include the half spheres.
    pub fn capsule(radius: f64, length: f64) -> Result<Self, PrimitiveError> {
        check("capsule", "radius", radius)?;
        check("capsule", "length", length)?;
        Ok(Self::Capsule { radius, half_length: 0.5 * length })
    }

    /// The solid with all dimensions scaled by a factor.
    pub fn scaled(&self, factor: f64) -> Result<Self, PrimitiveError> {
        let full = 2.0 * factor;
        match *self {
            Self::Box { half_extents } => Self::cuboid(half_extents.map(|h| full * h)),
            Self::Sphere { radius } => Self::sphere(factor * radius),
            Self::Cylinder { radius, half_length } => Self::cylinder(factor * radius, full * half_length),
            Self::Cone { radius, half_length } => Self::cone(factor * radius, full * half_length),
            Self::Capsule { radius, half_length } => Self::capsule(factor * radius, full * half_length),
        }
    }

    /// Radius of the smallest sphere around the origin that holds the solid.
    #[must_use]
    pub fn bounding_radius(&self) -> f64 {
        match *self {
            Self::Box { half_extents: [x, y, z] } => (x * x + y * y + z * z).sqrt(),
            Self::Sphere { radius } => radius,
            Self::Cylinder { radius, half_length } | Self::Cone { radius, half_length } => {
                radius.hypot(half_length)
            }
            Self::Capsule { radius, half_length } => radius + half_length,
        }
    }
}

impl Primitive {
    /// The half extents of the box around the solid, along its own axes.
    #[must_use]
    pub fn half_extents(&self) -> [f64; 3] {
        match *self {
            Self::Box { half_extents } => half_extents,
            Self::Sphere { radius } => [radius; 3],
            Self::Cylinder { radius, half_length } | Self::Cone { radius, half_length } => {
                [radius, radius, half_length]
            }
            Self::Capsule { radius, half_length } => [radius, radius, half_length + radius],
        }
    }

    /// Corners of the box around the solid.
    pub fn hull_points(&self) -> impl Iterator<Item = Point> + use<> {
        let [x, y, z] = self.half_extents();
        let sign = |i: u8, bit: u8| if i & bit == 0 { -1.0 } else { 1.0 };
        (0..8).map(move |i| Point::new(sign(i, 1) * x, sign(i, 2) * y, sign(i, 4) * z))
    }
}

fn check(shape: &'static str, dimension: &'static str, value: f64) -> Result<(), PrimitiveError> {
    if (0.0..=LARGEST_COORDINATE).contains(&value) {
        Ok(())
    } else {
        Err(PrimitiveError { shape, dimension, value })
    }
}
