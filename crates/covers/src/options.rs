//! Data types: requested size of a cover, and the errors of a cover.

use clearance_robot::LinkId;

/// How many spheres a cover has.
#[derive(Clone, Debug, PartialEq)]
pub enum CoverSize {
    /// At most this many for each link; the excess is minimised.
    PerLink(usize),
    /// At most this many for the whole robot; the largest excess is minimised. At least one for each link with collision geometry.
    Total(usize),
    /// At most these numbers for these links; the excess is minimised. Other links are left out.
    Links(Vec<(LinkId, usize)>),
    /// As few as possible, with an excess (m) of at most this: the largest distance of a sphere's point from the link.
    Excess(f64),
}

/// Reason why a robot cannot be covered as requested.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CoverError {
    /// A count is zero.
    #[error("a cover needs at least one sphere per link, not 0")]
    NoSpheres,
    /// The whole robot gets fewer spheres than it has links with collision geometry.
    #[error("{count} spheres are too few: {links} links have collision geometry, and each needs one")]
    TooFew {
        /// The requested number of spheres.
        count: usize,
        /// The number of links with collision geometry.
        links: usize,
    },
    /// No cover with the requested excess was found.
    #[error("link '{link}': no cover with an excess of at most {excess} m was found; allow a larger one")]
    NotReached {
        /// Name of the link.
        link: String,
        /// The requested excess (m).
        excess: f64,
    },
    /// An inner cover was requested by a total.
    #[error("inner covers are made by count per link or by depth, not by total")]
    NoTotal,
    /// A URDF text is not that of the robot.
    #[error("the URDF text is not the one that the robot was read from")]
    OtherUrdf,
    /// An excess or depth is not a positive number.
    #[error("the largest {what} is {value}, but must be a finite number of metres above zero")]
    BadLength {
        /// Name of the length.
        what: &'static str,
        /// Rejected value (m).
        value: f64,
    },
    /// A simplified mesh gets too few triangles.
    #[error(
        "simplified meshes need at least 4 triangles per link, not {count}: a closed surface has no fewer"
    )]
    FewTriangles {
        /// The requested number of triangles.
        count: usize,
    },
    /// No link has a collision mesh.
    #[error("no link has a collision mesh that could be simplified: primitives stay as they are")]
    NoMeshes,
    /// Simplified meshes were requested by a total, or by numbers of single links.
    #[error("meshes are simplified by a count of triangles per link, or by excess")]
    NoMeshSize,
    /// A link cannot be covered.
    #[error("link '{link}': {reason}")]
    Link {
        /// Name of the link.
        link: String,
        /// The reason.
        reason: String,
    },
}

impl CoverSize {
    /// Rejects counts of zero and lengths that are not positive.
    pub fn validate(&self) -> Result<(), CoverError> {
        match self {
            Self::PerLink(0) | Self::Total(0) => Err(CoverError::NoSpheres),
            Self::Links(counts) if counts.iter().any(|(_, count)| *count == 0) => Err(CoverError::NoSpheres),
            Self::Excess(value) if !(value.is_finite() && *value > 0.0) => {
                Err(CoverError::BadLength { what: "excess", value: *value })
            }
            _ => Ok(()),
        }
    }
}
