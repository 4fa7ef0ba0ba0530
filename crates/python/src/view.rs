//! Class `View`: robot and world in a web browser.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use clearance_view::{StateView, ViewAddress};
use numpy::PyArray1;
use pyo3::prelude::*;

use crate::checker_core::CheckerCore;
use crate::error::error;
use crate::state_queries::single;

/// Robot and world in a web browser, with a slider for each joint position: `Checker.view` makes it.
///
/// The server runs until `close()`, until the end of a `with` block, or until the object is no longer referenced.
#[pyclass(frozen, module = "clearance")]
#[derive(Debug)]
pub struct View {
    core: Arc<CheckerCore>,
    url: String,
    /// None once it is closed.
    server: Mutex<Option<StateView>>,
    /// The process of the server: a forked one has neither its thread nor a lock that another thread held.
    process: u32,
}

impl View {
    pub fn open(
        py: Python<'_>,
        core: &Arc<CheckerCore>,
        q: Option<&Bound<'_, PyAny>>,
        port: u16,
        open_browser: bool,
    ) -> PyResult<Self> {
        let state = q.map_or_else(|| Ok(core.space.rest().clone()), |q| single(core, q, "q"))?;
        let all = core.space.robot().position_names();
        let of_name = |name: &String| all.iter().position(|other| other == name);
        let positions: Vec<usize> = core.space.names().iter().filter_map(of_name).collect();
        let address: ViewAddress = port.to_string().parse().map_err(error)?;
        let opened = py
            .detach(|| StateView::open(&address, core.checker.clone(), &positions, state.positions()))
            .map_err(error)?;
        let url = opened.url().to_owned();
        if open_browser {
            py.import("webbrowser")?.call_method1("open", (&url,))?;
        }
        let (core, server) = (Arc::clone(core), Mutex::new(Some(opened)));
        Ok(Self { core, url, server, process: std::process::id() })
    }

    fn server(&self) -> MutexGuard<'_, Option<StateView>> {
        self.server.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn is_of_this_process(&self) -> bool {
        self.process == std::process::id()
    }

    /// Calls a function of the server, without the GIL.
    fn with_server<T: Send>(&self, py: Python<'_>, call: impl Fn(&StateView) -> T + Sync) -> PyResult<T> {
        if !self.is_of_this_process() {
            return Err(error(
                "the view belongs to the process that opened it: open another one by checker.view()",
            ));
        }
        let result = py.detach(|| self.server().as_ref().map(&call));
        result.ok_or_else(|| error("the view is closed: open another one by checker.view()"))
    }
}

impl Drop for View {
    fn drop(&mut self) {
        if !self.is_of_this_process() {
            // its thread runs in the other process only, and cannot be waited for
            std::mem::forget(self.server.get_mut().unwrap_or_else(PoisonError::into_inner).take());
        }
    }
}

#[pymethods]
impl View {
    /// URL of the page.
    #[getter]
    fn url(&self) -> &str {
        &self.url
    }

    /// The state that the page shows, shape (n,): the last one of `set_state` or of a slider.
    #[getter]
    fn state<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let state = self.with_server(py, StateView::state)?;
        Ok(PyArray1::from_vec(py, self.core.space.select(state.positions())))
    }

    /// Evaluates and shows the state `q`, shape (n,).
    fn set_state(&self, py: Python<'_>, q: &Bound<'_, PyAny>) -> PyResult<()> {
        let state = single(&self.core, q, "q")?;
        self.with_server(py, |server| server.set_state(state.positions()))?.map_err(error)
    }

    /// Stops the server. A closed view stays closed. A forked process leaves the server of its parent as it is.
    fn close(&self, py: Python<'_>) {
        if self.is_of_this_process() {
            py.detach(|| drop(self.server().take()));
        }
    }

    fn __enter__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    #[pyo3(signature = (*_exception))]
    fn __exit__(&self, py: Python<'_>, _exception: &Bound<'_, pyo3::types::PyTuple>) {
        self.close(py);
    }

    /// Link to the page, for notebooks.
    fn _repr_html_(&self) -> String {
        format!("<a href=\"{0}\" target=\"_blank\" rel=\"noopener\">{0}</a>", self.url)
    }

    fn __repr__(&self) -> String {
        let is_closed = self.is_of_this_process() && self.server().is_none();
        let closed = if is_closed { ", closed" } else { "" };
        format!("<clearance.View at {}{closed}>", self.url)
    }
}
