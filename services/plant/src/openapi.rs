//! The `OpenAPI` description of the routes.

use std::sync::LazyLock;

use serde_json::{Value, json};

/// The description as it is served, written once.
pub(crate) static DOCUMENT: LazyLock<String> = LazyLock::new(|| document().to_string());

fn document() -> Value {
    let count = |what: &str| json!({"type": "integer", "format": "int64", "minimum": 0, "description": what});
    let number = |what: &str| json!({"type": "number", "format": "double", "description": what});
    let seq = || count("number of the controller's deadline");
    let arrive = || count("when the command arrived, on the plant's clock, in nanoseconds");
    let tick = || count("the plant's latest tick");
    let y = || number("the output after that tick");
    let held = || number("the input that the plant holds");

    let state = object(
        &json!({"seq": seq(), "tick": tick(), "t_arrive_ns": arrive(), "y": y(), "u": held()}),
    );
    let acknowledgement = object(&json!({"seq": seq(), "t_arrive_ns": arrive()}));
    let now = count("when the plant was looked at, on its clock, in nanoseconds");
    let observation = object(&json!({"t_ns": now, "tick": tick(), "y": y(), "u": held()}));

    let parameter = |name: &str, schema: Value| json!({"name": name, "in": "query", "required": true, "schema": schema});
    let command = || {
        json!([
            parameter("seq", seq()),
            parameter(
                "t_send_ns",
                count("when the command was sent, on the controller's clock, in nanoseconds")
            ),
            parameter("u", number("the input, finite")),
        ])
    };
    let operation = |summary: &str, parameters: Value, content: Value| {
        let refused = |why: &str| json!({"description": why, "content": {"text/plain": {"schema": {"type": "string"}}}});
        json!({"get": {"summary": summary, "parameters": parameters, "responses": {
            "200": {"description": "done", "content": content},
            "400": refused("refused; the text names the field, and the input is unchanged"),
            "405": refused("not GET"),
            "413": refused("a body, where a command has none"),
            "414": refused("a query of more than 1024 bytes"),
            "500": refused("the plant's output is no longer finite"),
        }}})
    };
    let message = |name: &str| {
        let schema = json!({"schema": {"$ref": format!("#/components/schemas/{name}")}});
        json!({"application/x-www-form-urlencoded": schema, "application/json": schema})
    };

    json!({
        "openapi": "3.1.0",
        "info": {
            "title": "webloop plant",
            "version": env!("CARGO_PKG_VERSION"),
            "description": "A plant that runs free and takes its input over HTTP. Answers are URI-encoded queries, or JSON if the request accepts application/json.",
        },
        "paths": {
            "/closed": operation("Use this input and give the state", command(), message("State")),
            "/open": operation("Acknowledge a command without using it", command(), message("Acknowledgement")),
            "/state": operation("Give the state", json!([]), message("Observation")),
            "/health": operation("Say ok", json!([]), json!({"text/plain": {"schema": {"type": "string"}}})),
            "/openapi.json": operation("Give this description", json!([]), json!({"application/json": {"schema": {"type": "object"}}})),
        },
        "components": {"schemas": {
            "State": state,
            "Acknowledgement": acknowledgement,
            "Observation": observation,
        }},
    })
}

/// An object in which every property is required and no other is allowed.
fn object(properties: &Value) -> Value {
    let names: Vec<&String> = properties
        .as_object()
        .map(|map| map.keys().collect())
        .unwrap_or_default();
    json!({"type": "object", "required": names, "additionalProperties": false, "properties": properties})
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use endpoint::{Acknowledgement, Observation, State};

    use super::*;
    use crate::route::PATHS;

    #[test]
    fn every_path_is_described_and_every_description_has_a_path() {
        let document = document();
        let described: BTreeSet<&str> = document["paths"]
            .as_object()
            .expect("an object")
            .keys()
            .map(String::as_str)
            .collect();
        assert_eq!(described, BTreeSet::from(PATHS));
    }

    #[test]
    fn the_schemas_have_the_fields_of_the_messages() {
        let document = document();
        let check = |name: &str, message: Value| {
            let fields: BTreeSet<&String> =
                message.as_object().expect("an object").keys().collect();
            let schema = &document["components"]["schemas"][name]["properties"];
            let described: BTreeSet<&String> =
                schema.as_object().expect("an object").keys().collect();
            assert_eq!(described, fields, "{name}");
        };
        let state = State {
            seq: 0,
            tick: 0,
            t_arrive_ns: 0,
            y: 0.0,
            u: 0.0,
        };
        check("State", serde_json::to_value(state).expect("numbers"));
        let acknowledgement = Acknowledgement {
            seq: 0,
            t_arrive_ns: 0,
        };
        check(
            "Acknowledgement",
            serde_json::to_value(acknowledgement).expect("numbers"),
        );
        let observation = Observation {
            t_ns: 0,
            tick: 0,
            y: 0.0,
            u: 0.0,
        };
        check(
            "Observation",
            serde_json::to_value(observation).expect("numbers"),
        );
    }
}
