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
        Ok(Self { core: Arc::clone(core), url, server: Mutex::new(Some(opened)) })
    }

    fn server(&self) -> MutexGuard<'_, Option<StateView>> {
        self.server.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Calls a function of the server, without the GIL.
    fn with_server<T: Send>(&self, py: Python<'_>, call: impl Fn(&StateView) -> T + Sync) -> PyResult<T> {
        let result = py.detach(|| self.server().as_ref().map(&call));
        result.ok_or_else(|| error("the view is closed: open another one by checker.view()"))
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

    /// Stops the server. A closed view stays closed.
    fn close(&self, py: Python<'_>) {
        py.detach(|| drop(self.server().take()));
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
        let closed = if self.server().is_none() { ", closed" } else { "" };
        format!("<clearance.View at {}{closed}>", self.url)
    }
}
