//! The option `--view`, which shows robot and world in a web browser.

use clap::Args;
use clearance_ros::{View, ViewAddress};

use super::failure::Failure;
use super::run_args::print_line;

#[derive(Args, Clone, Copy, Debug)]
pub struct ViewArgs {
    /// Serve a live view for web browsers, at http://127.0.0.1:8642/ or a free port if that one is taken; ADDRESS is PORT,
    /// IP or IP:PORT. Any address but those of this machine's loopback shows the robot and its surroundings to everyone
    /// who can reach it
    #[arg(long, value_name = "ADDRESS", num_args = 0..=1, default_missing_value = "")]
    view: Option<ViewAddress>,
}

impl ViewArgs {
    /// Whether a view was requested.
    pub fn is_given(self) -> bool {
        self.view.is_some()
    }

    /// Opens the view, if one was requested. Does not print its address yet, because the node may fail to start.
    pub fn open(self) -> Result<Option<View>, Failure> {
        let address = self.view.as_ref();
        address.map(|address| View::open(address).map_err(Failure::input)).transpose()
    }

    /// Returns a function that prints the address of an open view. It is called when the view has data to show.
    pub fn announcement(self, view: Option<&View>) -> impl FnOnce() + Send + use<> {
        let url = view.map(|view| view.url().to_owned());
        let is_private = self.view.is_none_or(|address| address.is_private());
        move || {
            let Some(url) = url else { return };
            if !is_private {
                log::warn!(
                    "the view at {url} is open to everyone who can reach this machine: without a password they see the robot and its \
                     surroundings"
                );
            }
            if let Err(failure) = print_line(&format!("view: {url}")) {
                log::warn!("{failure}");
            }
        }
    }
}
