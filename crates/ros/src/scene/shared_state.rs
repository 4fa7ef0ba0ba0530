//! State shared between the loader and the threads of topics and services.

use std::sync::{Arc, Mutex};

use clearance_monitor::JointStateHistory;
use clearance_scene::{AnchorFrames, TransformTree};

use crate::clock::RosClock;
use crate::parameters::parameter_store::ParameterStore;
use crate::recording::recorder_handle::RecorderHandle;
use crate::scene::active_scene::CurrentScene;
use crate::scene::cloud_inbox::CloudMessages;

/// Transforms from tf, shared between the subscriptions and their users.
pub type Transforms = Arc<Mutex<TransformTree>>;

/// Data shared with the loader.
#[derive(Clone)]
pub struct SharedState {
    pub scene: CurrentScene,
    pub transforms: Transforms,
    /// The frames in which the loader places obstacles.
    pub anchor_frames: Arc<Mutex<AnchorFrames>>,
    pub clouds: Arc<CloudMessages>,
    /// History of joint states. Lock order: a holder of both this and the evaluation takes the evaluation first.
    pub joint_state_history: Arc<Mutex<JointStateHistory>>,
    pub store: ParameterStore,
    pub clock: Arc<RosClock>,
    pub recording: RecorderHandle,
}

impl SharedState {
    #[must_use]
    pub fn new(
        scene: CurrentScene,
        store: ParameterStore,
        clock: Arc<RosClock>,
        recording: RecorderHandle,
    ) -> Self {
        Self {
            scene,
            transforms: Transforms::default(),
            anchor_frames: Arc::default(),
            clouds: Arc::default(),
            joint_state_history: Arc::default(),
            store,
            clock,
            recording,
        }
    }
}
