//! `--view`: robot and world in a web browser.

use clap::Args;
use clearance::node::{View, ViewAddress};

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
    /// Whether a view was asked for.
    pub fn is_given(self) -> bool {
        self.view.is_some()
    }

    /// Opens the view, if it was asked for, and says where it is.
    pub fn open(self) -> Result<Option<View>, Failure> {
        let Some(address) = self.view else {
            return Ok(None);
        };
        let view = View::open(&address).map_err(Failure::input)?;
        if !address.is_private() {
            log::warn!(
                "the view at {} is open to everyone who can reach this machine: without a password they see the robot and its \
                 surroundings",
                view.url()
            );
        }
        print_line(&format!("view: {}", view.url()))?;
        Ok(Some(view))
    }
}
