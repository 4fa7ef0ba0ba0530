//! The standard parameter services, as used by `ros2 param`, and `/parameter_events`.
//!
//! The client library's own services return no descriptions, change parameters one by one, and lose the first requests
//! of clients that were started before the node.

use std::sync::Arc;

use clearance_geometry::VolumeKind;
use futures_lite::future;
use ros2_client::builtin_interfaces::Time as StampMessage;
use ros2_client::parameters::raw;
use ros2_client::rcl_interfaces::{
    DescribeParametersRequest, DescribeParametersResponse, GetParameterTypesRequest,
    GetParameterTypesResponse, GetParametersRequest, GetParametersResponse, ListParametersRequest,
    ListParametersResponse, ListParametersResult, SetParametersAtomicallyResponse, SetParametersRequest,
    SetParametersResponse,
};
use serde::{Deserialize, Serialize};

use crate::clock::RosClock;
use crate::dds::Message;
use crate::dds::middleware::Middleware;
use crate::dds::middleware_error::MiddlewareError;
use crate::dds::publisher::Publisher;
use crate::dds::quality::Quality;
use crate::dds::server::Server;
use crate::dds::type_name::TypeName;
use crate::names::Names;
use crate::parameters::declaration::{Declaration, Range};
use crate::parameters::declarations::DECLARATIONS;
use crate::parameters::declarations::declaration_of;
use crate::parameters::parameter_set::Parameters;
use crate::parameters::parameter_store::ParameterStore;
use crate::parameters::parameter_value::{Value, not_set};

/// The six parameter services of one node.
pub struct ParameterServices {
    store: ParameterStore,
    clock: Arc<RosClock>,
    node: String,
    events: Publisher<Event>,
    get: Server<GetParametersRequest, GetParametersResponse>,
    get_types: Server<GetParameterTypesRequest, GetParameterTypesResponse>,
    list: Server<ListParametersRequest, ListParametersResponse>,
    describe: Server<DescribeParametersRequest, DescribeParametersResponse>,
    set: Server<SetParametersRequest, SetParametersResponse>,
    set_atomically: Server<SetParametersRequest, SetParametersAtomicallyResponse>,
}

/// `rcl_interfaces/msg/ParameterEvent`.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Event(raw::ParameterEvent);

impl Message for Event {}

impl ParameterServices {
    pub fn open(
        middleware: &Middleware,
        names: &Names,
        store: ParameterStore,
        clock: Arc<RosClock>,
    ) -> Result<Self, MiddlewareError> {
        fn server<Request, Response>(
            middleware: &Middleware,
            names: &Names,
            name: &str,
            kind: &'static str,
        ) -> Result<Server<Request, Response>, MiddlewareError>
        where
            Request: Message + Clone + 'static,
            Response: Message + 'static,
        {
            let name = names.resolve_service(&format!("~/{name}"))?;
            middleware.server(&name, TypeName::new("rcl_interfaces", kind))
        }
        let events = names.resolve("/parameter_events")?;
        let event_kind = TypeName::new("rcl_interfaces", "ParameterEvent");
        let services = Self {
            node: names.full_node_name(),
            store,
            clock,
            events: middleware.publisher(&events, event_kind, Quality::Reliable)?,
            get: server(middleware, names, "get_parameters", "GetParameters")?,
            get_types: server(middleware, names, "get_parameter_types", "GetParameterTypes")?,
            list: server(middleware, names, "list_parameters", "ListParameters")?,
            describe: server(middleware, names, "describe_parameters", "DescribeParameters")?,
            set: server(middleware, names, "set_parameters", "SetParameters")?,
            set_atomically: server(
                middleware,
                names,
                "set_parameters_atomically",
                "SetParametersAtomically",
            )?,
        };
        let all: Vec<&Declaration> = DECLARATIONS.iter().collect();
        services.announce(&all, &[]);
        Ok(services)
    }

    /// Handles requests without end.
    pub async fn serve(&self) {
        let reading = future::zip(
            future::zip(
                serve_requests(&self.get, |r| self.values(&r)),
                serve_requests(&self.get_types, |r| self.types(&r)),
            ),
            future::zip(serve_requests(&self.list, list), serve_requests(&self.describe, |r| describe(&r))),
        );
        let writing = future::zip(
            serve_requests(&self.set, |r| self.change_each(&r)),
            serve_requests(&self.set_atomically, |r| self.change_together(&r)),
        );
        future::zip(reading, writing).await;
    }

    fn values(&self, request: &GetParametersRequest) -> GetParametersResponse {
        let parameters = self.store.get();
        let value =
            |name: &String| declaration_of(name).map_or_else(not_set, |d| d.get(&parameters).to_message());
        GetParametersResponse { values: request.names.iter().map(value).collect() }
    }

    fn types(&self, request: &GetParameterTypesRequest) -> GetParameterTypesResponse {
        let values = self.values(&GetParametersRequest { names: request.names.clone() }).values;
        GetParameterTypesResponse { values: values.iter().map(|value| value.ptype).collect() }
    }

    fn change_each(&self, request: &SetParametersRequest) -> SetParametersResponse {
        let changes = changes(request);
        let results = self.store.set_each(&changes);
        let made = (changes.iter().zip(&results)).filter(|(_, r)| r.is_ok()).map(|((n, _), _)| n);
        let made: Vec<&Declaration> = made.filter_map(|name| declaration_of(name)).collect();
        self.announce(&[], &made);
        SetParametersResponse { results: results.into_iter().map(result_message).collect() }
    }

    fn change_together(&self, request: &SetParametersRequest) -> SetParametersAtomicallyResponse {
        let changes = changes(request);
        let result = self.store.set_together(&changes);
        if result.is_ok() {
            let made: Vec<_> = changes.iter().filter_map(|(name, _)| declaration_of(name)).collect();
            self.announce(&[], &made);
        }
        SetParametersAtomicallyResponse { result: result_message(result) }
    }

    /// Publishes a change on `/parameter_events`.
    fn announce(&self, new: &[&Declaration], changed: &[&Declaration]) {
        if new.is_empty() && changed.is_empty() {
            return;
        }
        let parameters = self.store.get();
        let messages = |declarations: &[&Declaration]| {
            let message = |d: &&Declaration| raw::Parameter {
                name: d.name.to_owned(),
                value: d.get(&parameters).to_message(),
            };
            declarations.iter().map(message).collect()
        };
        let now = self.clock.now().unwrap_or_default();
        self.events.publish(Event(raw::ParameterEvent {
            stamp: StampMessage::from_nanos(now.nanoseconds()),
            node: self.node.clone(),
            new_parameters: messages(new),
            changed_parameters: messages(changed),
            deleted_parameters: Vec::new(),
        }));
    }
}

async fn serve_requests<Request, Response>(
    server: &Server<Request, Response>,
    respond: impl Fn(Request) -> Response,
) where
    Request: Message + 'static,
    Response: Message + 'static,
{
    loop {
        let (id, request) = server.next().await;
        server.respond(id, respond(request)).await;
    }
}

/// The changes that a request names, with their values.
pub fn changes(request: &SetParametersRequest) -> Vec<(String, Value)> {
    let change = |p: &raw::Parameter| (p.name.clone(), Value::from_message(&p.value));
    request.parameter.iter().map(change).collect()
}

fn result_message(result: Result<(), String>) -> raw::SetParametersResult {
    let (successful, reason) = match result {
        Ok(()) => (true, String::new()),
        Err(reason) => (false, reason),
    };
    raw::SetParametersResult { successful, reason }
}

/// Lists parameters as rclcpp does: all of them, or those that equal a prefix or lie below it. No parameter name of
/// this node has a dot.
#[expect(clippy::needless_pass_by_value, reason = "a request is answered once")]
fn list(request: ListParametersRequest) -> ListParametersResponse {
    let wanted = |name: &str| request.prefixes.is_empty() || request.prefixes.iter().any(|p| p == name);
    let names = DECLARATIONS.iter().map(|d| d.name).filter(|name| wanted(name)).map(str::to_owned);
    let result = ListParametersResult { names: names.collect(), prefixes: Vec::new() };
    ListParametersResponse { result }
}

fn describe(request: &DescribeParametersRequest) -> DescribeParametersResponse {
    let describe = |name: &String| match declaration_of(name) {
        Some(declaration) => descriptor(declaration),
        None => raw::ParameterDescriptor { name: name.clone(), ..blank_descriptor() },
    };
    DescribeParametersResponse { values: request.names.iter().map(describe).collect() }
}

fn descriptor(declaration: &Declaration) -> raw::ParameterDescriptor {
    let ranges = match declaration.range {
        Range::Bool
        | Range::Integer { .. }
        | Range::Word(_)
        | Range::Text
        | Range::Service
        | Range::Prefix
        | Range::Volumes
        | Range::Names(_)
        | Range::ObstacleLimits
        | Range::ObstacleSpeeds
        | Range::Point => Vec::new(),
        Range::Double { from, to } => {
            vec![raw::FloatingPointRange { from_value: from, to_value: to, step: 0.0 }]
        }
    };
    let integers = match declaration.range {
        Range::Integer { from, to } => vec![raw::IntegerRange { from_value: from, to_value: to, step: 1 }],
        _ => Vec::new(),
    };
    let unit = match declaration.unit {
        "" => String::new(),
        unit => format!(" [{unit}]"),
    };
    raw::ParameterDescriptor {
        name: declaration.name.to_owned(),
        r#type: declaration.get(&Parameters::default()).to_message().ptype,
        description: format!("{}{unit}", declaration.description),
        additional_constraints: match declaration.range {
            Range::Word(words) => words.join(" or "),
            Range::Point => "three numbers, or none".to_owned(),
            Range::Volumes => {
                let kinds = VolumeKind::ALL.map(VolumeKind::name).join(" or ");
                format!("{kinds}, and LINK=KIND, separated by commas")
            }
            Range::Bool
            | Range::Double { .. }
            | Range::Integer { .. }
            | Range::Text
            | Range::Service
            | Range::Prefix
            | Range::Names(_)
            | Range::ObstacleLimits
            | Range::ObstacleSpeeds => String::new(),
        },
        floating_point_range: ranges,
        integer_range: integers,
        read_only: declaration.is_fixed(),
        ..blank_descriptor()
    }
}

fn blank_descriptor() -> raw::ParameterDescriptor {
    raw::ParameterDescriptor {
        name: String::new(),
        r#type: raw::ParameterType::NOT_SET,
        description: String::new(),
        additional_constraints: String::new(),
        read_only: false,
        dynamic_typing: false,
        floating_point_range: Vec::new(),
        integer_range: Vec::new(),
    }
}
