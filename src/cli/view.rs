//! `clearance view`: a robot in a web browser, with a slider for each joint.

use clap::Args;
use clearance_view::{StateView, ViewAddress};

use super::exit_status::ExitStatus;
use super::failure::Failure;
use super::model_args::{ModelArgs, WorldArgs};
use super::run_args::{PairArgs, print_line};
use super::states;

#[derive(Args)]
pub struct ViewCommandArgs {
    #[command(flatten)]
    model: ModelArgs,

    #[command(flatten)]
    world: WorldArgs,

    #[command(flatten)]
    pairs: PairArgs,

    /// The first state, such as "j1=0.1 j2=-1.2"; other joints take 0, or the middle of limits that exclude 0
    #[arg(long, value_name = "J=X ...", allow_hyphen_values = true, default_value = "")]
    state: String,

    /// Address of the page: PORT, IP or IP:PORT. Any address but those of this machine's loopback shows the robot to everyone who can
    /// reach it, and lets them move it on the page
    #[arg(long, value_name = "ADDRESS", default_value = "", hide_default_value = true)]
    address: ViewAddress,
}

pub fn run(args: &ViewCommandArgs) -> Result<ExitStatus, Failure> {
    let checker = args.pairs.checker(&args.model, &args.world)?;
    let robot = checker.robot();
    let state = if args.state.trim().is_empty() {
        robot.default_configuration()
    } else {
        states::from_text("--state", &args.state, robot)?
    };
    if let Some(note) = robot.limits_note("state", [[&state]]) {
        log::warn!("{note}");
    }
    let positions: Vec<usize> = (0..robot.position_names().len()).collect();
    let (stop, stopped) = std::sync::mpsc::channel();
    // further signals while the server stops have no receiver
    let handler = move || {
        let _ = stop.send(());
    };
    ctrlc::set_handler(handler).map_err(Failure::input)?;
    let view =
        StateView::open(&args.address, checker, &positions, state.positions()).map_err(Failure::input)?;
    if !args.address.is_private() {
        log::warn!("the view at {} is open to everyone who can reach this machine", view.url());
    }
    print_line(&format!("view: {}", view.url()))?;
    // ends with the signal, or if the handler has ended
    let _ = stopped.recv();
    Ok(ExitStatus::SUCCESS)
}
