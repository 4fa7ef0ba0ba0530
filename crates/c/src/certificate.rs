//! C interface of certificates: reading and writing JSON, and verification.

use std::cell::RefCell;
use std::ffi::{CString, c_char};
use std::ptr;
use std::sync::OnceLock;

use clearance::verifier::{ExpectedMotion, VerificationStatistics};
use clearance::{Certificate, Trajectory, Verifier};
use clearance_bindings::JointSpace;

use crate::arguments::Arguments;
use crate::checker_options::{CheckSettings, clearance_checker_options};
use crate::motion_options::tube_of;
use crate::motion_queries::clearance_trajectory;
use crate::robot::clearance_robot;
use crate::status::{Failure, Outcome, call, call_for, clearance_status};
use crate::texts::c_text;
use crate::world::clearance_world;

/// A proof that a motion is free, for one robot in one world: `clearance_verify` checks it with code that is independent of the checker.
/// Immutable: any number of threads may use it.
///
/// It is the document that `clearance motion --certificate` writes.
#[derive(Debug)]
pub struct clearance_certificate {
    inner: Certificate,
    json: OnceLock<CString>,
}

impl clearance_certificate {
    /// A certificate of the library.
    pub fn new(inner: Certificate) -> Self {
        Self { inner, json: OnceLock::new() }
    }
}

/// Reads a certificate from JSON text. Rejected: text that is none, and certificates that were altered.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_certificate_from_json(
    json: *const c_char,
    certificate: *mut *mut clearance_certificate,
) -> clearance_status {
    call(|arguments| {
        let inner = Certificate::from_json(arguments.text(json, "json")?).map_err(Failure::rejected)?;
        arguments.write_handle(certificate, clearance_certificate::new(inner), "certificate")
    })
}

/// The certificate as one line of JSON, valid as long as the certificate; null if `certificate` is null.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_certificate_to_json(certificate: *const clearance_certificate) -> *const c_char {
    call_for(ptr::null(), |arguments| {
        let clearance_certificate { inner, json } = arguments.object(certificate, "certificate")?;
        Ok(json.get_or_init(|| c_text(&inner.to_json())).as_ptr())
    })
}

/// Number of segments of the motion.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_certificate_segment_count(certificate: *const clearance_certificate) -> usize {
    call_for(0, |arguments| Ok(arguments.object(certificate, "certificate")?.inner.segments.len()))
}

/// Number of pairs of bodies that are proven apart.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_certificate_pair_count(certificate: *const clearance_certificate) -> usize {
    call_for(0, |arguments| Ok(arguments.object(certificate, "certificate")?.inner.pairs.len()))
}

/// Frees a certificate; null is ignored.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_certificate_free(certificate: *mut clearance_certificate) {
    call(|arguments| arguments.release(certificate, "certificate"));
}

/// Expected content of a certificate: options and motion. Start with `clearance_expectation_default`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct clearance_expectation {
    /// Options of the check: they must be the same, without objects that the world does not have. Null for the defaults.
    pub options: *const clearance_checker_options,
    /// The motion; a certificate of another motion is rejected. For a straight motion, a path of two states without times. Its states are
    /// those of a checker with these options. If it is null, only the proof is checked: then compare the motion in the certificate with
    /// yours.
    pub motion: *const clearance_trajectory,
    /// Tracking tolerance (rad, m) of the check: one for each position, 1 for the same of all, or none.
    pub tube: *const f64,
    /// Number of tracking tolerances.
    pub tube_count: usize,
    /// Tolerance (m) of the check; 0 for any.
    pub tolerance: f64,
    /// Distance (m) that the proof has to keep at least, besides paddings; 0 for any.
    pub margin: f64,
}

impl Default for clearance_expectation {
    fn default() -> Self {
        Self {
            options: ptr::null(),
            motion: ptr::null(),
            tube: ptr::null(),
            tube_count: 0,
            tolerance: 0.0,
            margin: 0.0,
        }
    }
}

/// An expectation that any motion meets.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_expectation_default() -> clearance_expectation {
    clearance_expectation::default()
}

/// Result of a verification.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct clearance_verification {
    /// True only if the certificate proves the motion free.
    pub is_valid: bool,
    /// Why the certificate is rejected, or null; valid until the next verification in this thread.
    pub reason: *const c_char,
    /// Number of segments that were verified.
    pub segments: usize,
    /// Number of pairs of bodies.
    pub pairs: usize,
    /// Number of proofs.
    pub proofs: usize,
}

thread_local! {
    static REASON: RefCell<Option<CString>> = const { RefCell::new(None) };
}

/// Verifies that a certificate proves a motion of this robot in this world free, with code that is independent of the checker.
///
/// A null `world` is empty. A certificate that does not prove it is a result, not an error: `is_valid` is false, with a reason.
/// Rejected: options and expected motions that a checker would reject, too.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_verify(
    certificate: *const clearance_certificate,
    robot: *const clearance_robot,
    world: *const clearance_world,
    expectation: *const clearance_expectation,
    verification: *mut clearance_verification,
) -> clearance_status {
    call(|arguments| {
        let certificate = &arguments.object(certificate, "certificate")?.inner;
        let model = &arguments.object(robot, "robot")?.model;
        let world = arguments.object_or_none(world, "world")?;
        let scene = world.map(|world| world.scene.clone()).unwrap_or_default();
        let expectation = arguments.object_or_none(expectation, "expectation")?.copied().unwrap_or_default();
        let settings = CheckSettings::read(arguments, expectation.options)?;
        settings.check_names(model, &scene)?;
        let expected = expectation.read(arguments, &settings.space(model)?)?;
        let (matrix, in_scene) = (settings.matrix(model, &scene), settings.in_scene(&scene));
        let verified = Verifier::new(model, &scene.world, &in_scene, matrix.as_ref())
            .and_then(|verifier| verifier.verify_expected(certificate, &expected));
        let reason = verified.as_ref().err().map(|why| c_text(&why.to_string()));
        let written = result(&verified.unwrap_or_default(), reason);
        arguments.write(verification, written, "verification")
    })
}

impl clearance_expectation {
    fn read(&self, arguments: Arguments<'_>, space: &JointSpace) -> Outcome<ExpectedMotion> {
        let tube = tube_of(arguments, self.tube, self.tube_count, space)?;
        let motion = arguments.object_or_none(self.motion, "expectation.motion")?;
        let motion = motion.map(|motion| motion.read(arguments, space)).transpose()?;
        let with_tube = |motion: Trajectory| match &tube {
            Some(tube) => motion.map(|segment| segment.with_tube(space.robot(), tube.clone())),
            None => Ok(motion),
        };
        let motion = motion.map(with_tube).transpose().map_err(Failure::rejected)?;
        let is_tolerance = self.tolerance >= 0.0 && self.tolerance.is_finite();
        if !is_tolerance {
            return Err(Failure::rejected(format!(
                "expectation.tolerance is {}, but must be finite and more than zero metres, or 0 for any",
                self.tolerance
            )));
        }
        let is_margin = self.margin >= 0.0 && self.margin.is_finite();
        if !is_margin {
            return Err(Failure::rejected(format!(
                "expectation.margin is {}, but must be finite and zero or more metres",
                self.margin
            )));
        }
        let margin = Some(self.margin);
        let tolerance = (self.tolerance != 0.0).then_some(self.tolerance);
        Ok(ExpectedMotion { motion, any_obstacle_motion: false, tube, tolerance, margin })
    }
}

fn result(counts: &VerificationStatistics, reason: Option<CString>) -> clearance_verification {
    let text = reason.as_ref().map_or(ptr::null(), |reason| reason.as_ptr());
    // the text does not move with its owner; if the thread is about to end, there is none
    let kept = REASON.try_with(|last| last.replace(reason)).is_ok();
    clearance_verification {
        is_valid: text.is_null(),
        reason: if kept { text } else { c"".as_ptr() },
        segments: counts.segments,
        pairs: counts.pairs,
        proofs: counts.proofs,
    }
}
