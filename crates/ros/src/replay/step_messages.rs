//! Messages of a recorded step, and the orders that are read from them.

use clearance_monitor::{JointStateInput, SourceId};
use ros2_interfaces_jazzy_serde::sensor_msgs::msg::JointState;
use ros2_interfaces_jazzy_serde::std_msgs::msg::String as StringMessage;

use crate::dds::cdr;
use crate::messages::joint_state::joint_state_input;
use crate::recording::mcap_file::RawMessage;
use crate::recording::step::{Clocks, OrderStep, SceneDoor};
use crate::scene::command_conversion::{
    attached_order, clear_octomap, object_order, octomap_order, scene_order, unreadable_order, world_order,
};
use crate::scene::loader_command::Order;
use crate::scene::scene_command::SceneOrder;

/// The messages of a step, in their order.
pub(super) struct StepMessages(std::vec::IntoIter<RawMessage>);

impl StepMessages {
    pub fn new(messages: Vec<RawMessage>) -> Self {
        Self(messages.into_iter())
    }

    pub fn raw(&mut self, what: &str) -> Result<RawMessage, String> {
        self.0.next().ok_or_else(|| format!("{what} is missing before a step"))
    }

    pub fn is_empty(&self) -> bool {
        self.0.as_slice().is_empty()
    }

    pub fn joint_state(&mut self, source: &str) -> Result<JointStateInput, String> {
        let message: JointState = self.next("a joint state")?;
        Ok(joint_state_input(message, source_id(source)?))
    }

    pub fn next<M: serde::de::DeserializeOwned>(&mut self, what: &str) -> Result<M, String> {
        let raw = self.raw(what)?;
        cdr::decode(&raw.data).map_err(|why| format!("{} ({what}): {why}", raw.topic))
    }
}

fn source_id(hexadecimal: &str) -> Result<SourceId, String> {
    let wrong = || "the publisher of a joint state is not 32 hexadecimal digits".to_owned();
    let number = u128::from_str_radix(hexadecimal, 16).map_err(|_| wrong())?;
    (hexadecimal.len() == 32).then(|| SourceId(number.to_be_bytes())).ok_or_else(wrong)
}

/// Reads an order of the loader and its message.
pub(super) fn read_order(order: OrderStep, messages: &mut StepMessages) -> Result<Order, String> {
    let text =
        |messages: &mut StepMessages| messages.next::<StringMessage>("a description").map(|text| text.data);
    Ok(match order {
        OrderStep::Description => Order::Description(text(messages)?),
        OrderStep::Semantic => Order::Semantic(text(messages)?),
        OrderStep::Parameters => Order::Parameters,
        OrderStep::Clouds => Order::Clouds,
        OrderStep::Display => Order::Display,
        OrderStep::Frames => Order::Frames,
        OrderStep::ClearOctomap => Order::Scene(Box::new(clear_octomap())),
        OrderStep::Unreadable { by } => Order::Scene(Box::new(unreadable_order(by))),
        OrderStep::Scene { by, came, unknown_is_occupied, lost } => {
            let order = read_scene_order(by, came, unknown_is_occupied, messages)?;
            Order::Scene(Box::new(order.after(lost)))
        }
    })
}

fn read_scene_order(
    by: SceneDoor,
    came: Clocks,
    unknown: bool,
    messages: &mut StepMessages,
) -> Result<SceneOrder, String> {
    let (name, came) = (by.name(), came.into());
    Ok(match by {
        SceneDoor::CollisionObject => object_order(&messages.next(name)?),
        SceneDoor::AttachedCollisionObject => attached_order(&messages.next(name)?),
        SceneDoor::PlanningSceneWorld => world_order(messages.next(name)?, unknown, came),
        SceneDoor::PlanningScene | SceneDoor::ApplyPlanningScene | SceneDoor::GetPlanningScene => {
            scene_order(by, messages.next(name)?, unknown, came)
        }
        SceneDoor::OctomapBinary | SceneDoor::OctomapFull => {
            octomap_order(by, messages.next(name)?, unknown, came)
        }
    })
}
