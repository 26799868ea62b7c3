//! The `OpenAPI` description of the routes.

use std::sync::LazyLock;

use endpoint::MessageRow;
use serde_json::{Value, json};

/// The paths of the API, without the page's files.
pub(crate) const PATHS: [&str; 10] = [
    "/closed",
    "/open",
    "/state",
    "/reset",
    "/socket",
    "/session",
    "/session/rows",
    "/session/end",
    "/health",
    "/openapi.json",
];

/// The pattern of a session's token.
const TOKEN: &str = "^[0-9a-f]{32}$";

/// The responses that reject a body.
const BODY: [(u16, &str); 3] = [
    (408, "the body did not come within 5 s"),
    (
        413,
        "a body of more than 64 KiB, or a claim of more than 1 KiB",
    ),
    (415, "another content type"),
];

/// The description as served; written once.
pub(crate) static DOCUMENT: LazyLock<String> = LazyLock::new(|| document().to_string());

fn document() -> Value {
    let count = |what: &str| json!({"type": "integer", "format": "int64", "minimum": 0, "description": what});
    // A number, or two where the plant has two inputs or outputs; in a query with a comma between them.
    let number = |what: &str| {
        let one = json!({"type": "number", "format": "double"});
        let two = json!({"type": "array", "items": one, "minItems": 2, "maxItems": 2});
        json!({"oneOf": [one, two], "description": what})
    };
    let t_send = || count("when the command was sent, on the controller's clock, in nanoseconds");
    let seq = || count("number of the controller's deadline; of the arrival, if it gives none");
    let arrive = || count("when the command arrived, on the plant's clock, in nanoseconds");
    let tick = || count("the plant's latest tick");
    let y = || number("the output after that tick, or both of them");
    let u = || number("the input, finite, or both of them");
    let held = || number("the input that the plant holds, or both of them");

    let state = object(
        &json!({"seq": seq(), "tick": tick(), "t_arrive_ns": arrive(), "y": y(), "u": held()}),
    );
    let acknowledgement = object(&json!({"seq": seq(), "t_arrive_ns": arrive()}));
    let now = count("when the state was read, on the plant's clock, in nanoseconds");
    let observation = object(&json!({
        "t_ns": now,
        "tick": tick(),
        "y": y(),
        "u": held(),
        "u_applied": number("the input of the latest tick, behind watchdog and actuator, or both of them"),
        "safe": {"type": "boolean", "description": "whether the watchdog acts, since no command has come for too long"},
        "trips": count("how often it has begun to act"),
    }));

    let crc = json!({"type": "string", "pattern": "^[0-9a-f]{8}$", "description": "CRC-32C of the query before \
                     `&crc=`, its last field; the answer then ends with its own"});
    let command = || {
        let mut parameters = vec![
            parameter("query", "u", &u()),
            parameter("query", "seq", &seq()),
            parameter("query", "t_send_ns", &t_send()),
            parameter("query", "crc", &crc),
            session_header(false),
        ];
        // A simple controller need not know them.
        for optional in &mut parameters[1..4] {
            optional["required"] = false.into();
        }
        parameters
    };
    let refusals = [
        (409, "another client is in control, or the session is over"),
        (413, "a body, where a command has none"),
        (500, "the plant's output is not finite any more"),
    ];
    let operation = |summary: &str, parameters: Vec<Value>, content: Value| {
        let done = json!({"description": "done", "content": content});
        json!({"get": {
            "summary": summary,
            "parameters": parameters,
            "responses": responses("200", &done, &refusals),
        }})
    };
    let message = |name: &str| {
        let schema = json!({"schema": {"$ref": format!("#/components/schemas/{name}")}});
        json!({"application/x-www-form-urlencoded": schema, "application/json": schema})
    };

    let mut health = operation(
        "Say ok, and what was refused by kind",
        vec![],
        json!({"text/plain": {"schema": {"type": "string"}}}),
    );
    health["get"]["responses"]["503"] = json!({
        "description": "the plant's output is not finite any more",
        "content": {"text/plain": {"schema": {"type": "string"}}},
    });

    json!({
        "openapi": "3.1.0",
        "info": {
            "title": "webloop plant",
            "version": env!("CARGO_PKG_VERSION"),
            "description": "A free-running plant that takes its input over HTTP. Answers are \
                            URI-encoded queries, or JSON if the request accepts application/json. \
                            A page needs a session to command it; while a page holds one, commands \
                            need its token, as always where the plant's lease is token. The page itself is at /.",
        },
        "paths": {
            "/closed": operation("Use this input and give the state", command(), message("State")),
            "/open": operation("Acknowledge a command without using it", command(), message("Acknowledgement")),
            "/reset": reset(),
            "/socket": socket(),
            "/state": operation("Give the state", vec![], message("Observation")),
            "/session": session(),
            "/session/rows": rows(),
            "/session/end": end(),
            "/health": health,
            "/openapi.json": operation("Give this description", vec![], json!({"application/json": {"schema": {"type": "object"}}})),
        },
        "components": {"schemas": {
            "State": state,
            "Acknowledgement": acknowledgement,
            "Observation": observation,
        }},
    })
}

fn reset() -> Value {
    let done =
        json!({"description": "the model is at rest from the next tick on, and its input is 0"});
    let refusals = [
        (409, "another client is in control, or the session is over"),
        (413, "a body"),
        (501, "the plant is a program, which cannot be reset"),
    ];
    json!({"post": {
        "summary": "Put the plant back to rest",
        "parameters": [session_header(false)],
        "responses": responses("204", &done, &refusals),
    }})
}

fn socket() -> Value {
    let mode = json!({"type": "string", "enum": ["closed", "open"]});
    let token = json!({"type": "string", "pattern": TOKEN});
    let mut session = parameter("query", "session", &token);
    session["required"] = false.into();
    let refusals = [
        (409, "another client is in control, or the session is over"),
        (426, "not the handshake of RFC 6455"),
    ];
    let done = json!({"description": "a WebSocket: each text message is the query of a command, \
                                      each answer the one that it would get over HTTP; an \
                                      unreadable message closes it with 1008, one longer than 1024 \
                                      bytes with 1009"});
    json!({"get": {
        "summary": "Carry commands over a WebSocket",
        "parameters": [parameter("query", "mode", &mode), session],
        "responses": responses("101", &done, &refusals),
    }})
}

fn session() -> Value {
    let mut client = object(
        &json!({"client": {"type": "string", "maxLength": 200, "description": "what the page calls itself"},
            "rows": {"type": "boolean", "description": "whether its rows will be sent here; true, if not given"}}),
    );
    client["required"] = json!(["client"]);
    let h = json!({"type": "integer", "format": "int64", "description": "the plant's sample time in nanoseconds"});
    let mut grant = object(&json!({
        "session": {"type": "string", "pattern": TOKEN, "description": "the token"},
        "h_ns": h,
        "late": {"type": "string", "enum": ["apply", "drop"], "description": "what the plant does \
                                                                              with an overtaken \
                                                                              command"},
        "law": {"type": "object", "description": "the control law to follow; the paper's PI, if there is none"},
        "reference": {"type": "array", "description": "the changes of a reference that moves: pairs of \
                                                       nanoseconds from the first deadline on, and r; the \
                                                       first is at 0", "items": {"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 2}},
    }));
    grant["required"] = json!(["session", "h_ns", "late"]);
    let count = |what: &str| json!({"type": "integer", "format": "int64", "description": what});
    let mut status = object(&json!({
        "state": {"type": "string", "enum": ["free", "held", "ended"]},
        "client": {"type": "string"},
        "commands": count("commands of the session"),
        "rows": count("rows that it has sent"),
        "idle_ms": count("milliseconds since it was last heard"),
        "outcome": {"type": "string", "description": "how it ended, as the page reports it; absent \
                                                      until then"},
        "reason": {"type": "string", "description": "why"},
    }));
    // The last two are present only after its end.
    status["required"] = json!(["state", "client", "commands", "rows", "idle_ms"]);
    let json = |schema: &Value| json!({"description": "done", "content": {"application/json": {"schema": schema}}});
    json!({
        "get": {
            "summary": "Say who is in control",
            "responses": responses("200", &json(&status), &[]),
        },
        "post": {
            "summary": "Begin a session",
            "requestBody": {"required": true, "content": {"application/json": {"schema": client}}},
            "responses": responses("200", &json(&grant), &[(409, "another client is in control"), BODY[0], BODY[1], BODY[2]]),
        },
    })
}

fn rows() -> Value {
    let chunk = json!({"type": "integer", "format": "int64", "minimum": 0, "description": "number of the chunk, from 0; one that was taken before is well received and left alone"});
    let schema = json!({"type": "string", "description": format!("lines of CSV without a header: {}", MessageRow::COLUMNS.join(","))});
    told(
        "Take message rows of the page",
        &[parameter("query", "chunk", &chunk), session_header(true)],
        &json!({"text/csv": {"schema": schema}}),
    )
}

fn end() -> Value {
    told(
        "Take the page's report and end the session",
        &[session_header(true)],
        &json!({"application/json": {"schema": {"type": "object"}}}),
    )
}

/// A POST without content in its answer.
fn told(summary: &str, parameters: &[Value], content: &Value) -> Value {
    let done = json!({"description": "taken"});
    let turn = (409, "out of turn, or the session is over");
    json!({"post": {
        "summary": summary,
        "parameters": parameters,
        "requestBody": {"required": true, "content": content},
        "responses": responses("204", &done, &[turn, BODY[0], BODY[1], BODY[2]]),
    }})
}

fn parameter(place: &str, name: &str, schema: &Value) -> Value {
    json!({"name": name, "in": place, "required": true, "schema": schema})
}

fn session_header(required: bool) -> Value {
    let schema = json!({"type": "string", "pattern": TOKEN, "description": "the session's token"});
    json!({"name": "Webloop-Session", "in": "header", "required": required, "schema": schema})
}

/// The response on success, and those that reject: `refusals`, and the ones that every path has.
fn responses(status: &str, done: &Value, refusals: &[(u16, &str)]) -> Value {
    let any = [
        (
            400,
            "refused; the text names the field, and nothing is changed",
        ),
        (403, "from a page of another origin"),
        (405, "not a method of this path"),
        (414, "a query of more than 1024 bytes"),
    ];
    let mut responses = json!({status: done});
    for (status, why) in any.iter().chain(refusals) {
        let text = json!({"text/plain": {"schema": {"type": "string"}}});
        responses[status.to_string()] = json!({"description": why, "content": text});
    }
    responses
}

/// An object in which every property is required and no other is permitted.
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

    #[test]
    fn the_file_beside_the_crate_is_the_description() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/openapi.json");
        let text = format!("{:#}\n", document());
        if std::env::var_os("WEBLOOP_TEST_WRITE").is_some() {
            std::fs::write(path, &text).expect("the checkout can be written");
        }
        let there = std::fs::read_to_string(path).unwrap_or_default();
        assert!(there == text, "WEBLOOP_TEST_WRITE=1 writes it anew");
    }

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
            y: 0.0.into(),
            u: 0.0.into(),
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
            y: 0.0.into(),
            u: 0.0.into(),
            u_applied: 0.0.into(),
            safe: false,
            trips: 0,
        };
        check(
            "Observation",
            serde_json::to_value(observation).expect("numbers"),
        );
    }
}
