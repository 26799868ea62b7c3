//! The `OpenAPI` description of the routes.

use endpoint::MessageRow;
use serde_json::{Value, json};

use crate::session::CLIENT_CHARS;

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

/// The patterns of a session's token and of a checksum.
const TOKEN: &str = "^[0-9a-f]{32}$";
const CHECKSUM: &str = "^[0-9a-f]{8}$";

/// A whole number from 0 to 2^64 - 1, and a finite one, as rows are to have them.
const COUNT: &str = "[0-9]{1,19}";
const NUMBER: &str = "-?[0-9]{1,20}(\\.[0-9]{1,20})?(e[+-]?[0-9]{1,2})?";

/// What fields say that several messages have.
const SEQ: &str = "number of the controller's deadline; of the arrival, if it gives none";
const INPUT: &str = "the input, finite, or both of them";
const SEND: &str = "when the command was sent, on the controller's clock, in nanoseconds";
const ARRIVE: &str = "when the command arrived, on the plant's clock, in nanoseconds";
const TICK: &str = "the plant's latest tick";
const OUTPUT: &str = "the output after that tick, or both of them";
const HELD: &str = "the input that the plant holds, or both of them";

/// The responses that reject a body.
const BODY: [(u16, &str); 5] = [
    (408, "the body did not come within 5 s"),
    (
        413,
        "a body of more than 64 KiB, or a claim of more than 1 KiB",
    ),
    (415, "another content type"),
    (500, "a file cannot be written"),
    (503, "too many bodies are on their way"),
];

/// The description of a plant with so many inputs and outputs; of any plant, if they are not told.
pub(crate) fn describe(signals: Option<[usize; 2]>) -> Value {
    let [inputs, outputs] = signals.map_or([None; 2], |counts| counts.map(Some));
    json!({
        "openapi": "3.1.0",
        "info": {
            "title": "webloop plant",
            "version": env!("CARGO_PKG_VERSION"),
            "description": "A free-running plant that takes its input over HTTP. Answers are \
                            URI-encoded queries, or JSON if the request accepts application/json. \
                            A page needs a session to command it; while a page holds one, commands \
                            need its token, as always where the plant's lease is token. The page itself is at /. \
                            On the same port it takes commands as lines of a bare TCP connection, whose first is \
                            mode=closed or mode=open, and as datagrams if it was started so.",
        },
        "paths": {
            "/closed": commanded("Use this input and give the state", inputs, "State"),
            "/open": commanded("Acknowledge a command without using it", inputs, "Acknowledgement"),
            "/reset": reset(),
            "/socket": socket(),
            "/state": operation("Give the state", &[], &message("Observation")),
            "/session": session(),
            "/session/rows": rows(),
            "/session/end": end(),
            "/health": health(),
            "/openapi.json": operation("Give this description", &[], &json!({"application/json": {"schema": {"type": "object"}}})),
        },
        "components": {"schemas": {
            "Command": posted(inputs),
            "State": state(inputs, outputs),
            "Acknowledgement": acknowledgement(),
            "Observation": observation(inputs, outputs),
        }},
    })
}

fn state(inputs: Option<usize>, outputs: Option<usize>) -> Value {
    signed(object(&json!({
        "seq": count(SEQ),
        "tick": count(TICK),
        "t_arrive_ns": count(ARRIVE),
        "y": number(outputs, OUTPUT),
        "u": number(inputs, HELD),
    })))
}

fn acknowledgement() -> Value {
    signed(object(
        &json!({"seq": count(SEQ), "t_arrive_ns": count(ARRIVE)}),
    ))
}

/// An answer with the last field that it has if its command has it.
fn signed(mut answer: Value) -> Value {
    answer["properties"]["crc"] = json!({"type": "string", "pattern": CHECKSUM, "description": "CRC-32C of the \
        answer before `&crc=`, its last field; only of an answer that is a query, to a command with `crc`"});
    answer
}

fn observation(inputs: Option<usize>, outputs: Option<usize>) -> Value {
    object(&json!({
        "t_ns": count("when the state was read, on the plant's clock, in nanoseconds"),
        "tick": count(TICK),
        "y": number(outputs, OUTPUT),
        "u": number(inputs, HELD),
        "u_applied": number(inputs, "the input of the latest tick, behind watchdog and actuator, or both of them"),
        "safe": {"type": "boolean", "description": "whether the watchdog acts, since no command has come for too long"},
        "trips": count("how often it has begun to act"),
    }))
}

/// A GET of a command, and a POST of one.
fn commanded(summary: &str, inputs: Option<usize>, answer: &str) -> Value {
    let mut paths = operation(summary, &command(inputs), &message(answer));
    let done = json!({"description": "done", "content": message(answer)});
    let refusals = [
        (408, "the body did not come within 5 s"),
        (409, "another client is in control, or the session is over"),
        (413, "a body of more than 1 KiB"),
        (415, "another content type"),
        (500, "the plant's output is not finite any more"),
        (503, "too many bodies are on their way"),
    ];
    let command = json!({"schema": {"$ref": "#/components/schemas/Command"}});
    paths["post"] = json!({
        "summary": format!("{summary}: the command is a body, and has no checksum"),
        "parameters": [optional_session_header()],
        "requestBody": {"required": true, "content": {"application/json": command}},
        "responses": responses("200", &done, &refusals),
    });
    paths
}

/// A command as a body.
fn posted(inputs: Option<usize>) -> Value {
    let mut command = object(&json!({
        "u": number(inputs, INPUT),
        "seq": count(SEQ),
        "t_send_ns": count(SEND),
    }));
    // A simple controller need not know the others.
    command["required"] = json!(["u"]);
    command
}

/// The parameters of a command.
fn command(inputs: Option<usize>) -> Vec<Value> {
    let u = number(inputs, INPUT);
    let t_send = count(SEND);
    let crc = json!({"type": "string", "pattern": CHECKSUM, "description": "CRC-32C of the query before \
                     `&crc=`, its last field; an answer that is a query then ends with its own"});
    let mut parameters = vec![
        parameter("query", "u", &u),
        parameter("query", "seq", &count(SEQ)),
        parameter("query", "t_send_ns", &t_send),
        parameter("query", "crc", &crc),
        optional_session_header(),
    ];
    // Two numbers stand in one field.
    parameters[0]["style"] = "form".into();
    parameters[0]["explode"] = false.into();
    // A simple controller need not know them.
    for optional in &mut parameters[1..4] {
        optional["required"] = false.into();
    }
    parameters
}

/// A GET of a command, or of something to look at.
fn operation(summary: &str, parameters: &[Value], content: &Value) -> Value {
    let done = json!({"description": "done", "content": content});
    let refusals = [
        (409, "another client is in control, or the session is over"),
        (413, "a body, where a command has none"),
        (500, "the plant's output is not finite any more"),
    ];
    json!({"get": {
        "summary": summary,
        "parameters": parameters,
        "responses": responses("200", &done, &refusals),
    }})
}

/// An answer in either form.
fn message(name: &str) -> Value {
    let schema = json!({"schema": {"$ref": format!("#/components/schemas/{name}")}});
    json!({"application/x-www-form-urlencoded": schema, "application/json": schema})
}

fn health() -> Value {
    let mut health = operation(
        "Say ok, and what was refused by kind",
        &[],
        &json!({"text/plain": {"schema": {"type": "string"}}}),
    );
    health["get"]["responses"]["503"] = json!({
        "description": "the plant's output is not finite any more",
        "content": {"text/plain": {"schema": {"type": "string"}}},
    });
    health
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
        "parameters": [optional_session_header()],
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
        (413, "a body"),
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
        &json!({"client": {"type": "string", "maxLength": CLIENT_CHARS, "pattern": "^[^\\u0000-\\u001f\\u007f-\\u009f]*$", "description": "what the page calls itself, on one line"},
            "rows": {"type": "boolean", "description": "whether its rows will be sent here; true, if not given"}}),
    );
    client["required"] = json!(["client"]);
    let h = count("the plant's sample time in nanoseconds");
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
            "responses": responses("200", &json(&status), &[(413, "a body")]),
        },
        "post": {
            "summary": "Begin a session",
            "requestBody": {"required": true, "content": {"application/json": {"schema": client}}},
            "responses": responses("200", &json(&grant), &[&[(409, "another client is in control")], &BODY[..]].concat()),
        },
    })
}

fn rows() -> Value {
    let chunk = count(
        "number of the chunk, from 0; one that was taken before is well received and left alone",
    );
    // What an outcome has beside r, in open and in closed loop.
    let missed = format!(",,,{NUMBER},,,,,missed,");
    let lost =
        format!("{COUNT},,,{NUMBER},(,,|{NUMBER},{NUMBER},){NUMBER},,(timeout|failed),({COUNT})?");
    let answered = format!(
        "{COUNT},{COUNT},{COUNT},{NUMBER},(,,{NUMBER},|{NUMBER},{NUMBER},{NUMBER},{COUNT}),answered,({COUNT})?"
    );
    let row = format!("{COUNT},{COUNT},({missed}|{lost}|{answered})");
    let schema = json!({
        "type": "string",
        "pattern": format!("^({row}(\\r?\\n{row})*\\n?)?$"),
        "description": format!(
            "lines of CSV without a header: {}; what was received was not before it was sent",
            MessageRow::COLUMNS.join(",")
        ),
    });
    told(
        "Take message rows of the page",
        &[parameter("query", "chunk", &chunk), session_header()],
        &json!({"text/csv": {"schema": schema}}),
    )
}

fn end() -> Value {
    told(
        "Take the page's report and end the session",
        &[session_header()],
        &json!({"application/json": {"schema": {"description": "any JSON; where it is an object, `outcome` and `reason` are passed on"}}}),
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
        "responses": responses("204", &done, &[&[turn], &BODY[..]].concat()),
    }})
}

/// A whole number.
fn count(what: &str) -> Value {
    json!({"type": "integer", "minimum": 0, "maximum": u64::MAX, "description": what})
}

/// A number for each of so many inputs or outputs, in a query with a comma between them.
fn number(count: Option<usize>, what: &str) -> Value {
    let one = json!({"type": "number", "format": "double"});
    let two = json!({"type": "array", "items": one, "minItems": 2, "maxItems": 2});
    let mut schema = match count {
        None => json!({"oneOf": [one, two]}),
        Some(1) => one,
        Some(_) => two,
    };
    schema["description"] = what.into();
    schema
}

fn parameter(place: &str, name: &str, schema: &Value) -> Value {
    json!({"name": name, "in": place, "required": true, "schema": schema})
}

fn session_header() -> Value {
    let schema = json!({"type": "string", "pattern": TOKEN, "description": "the session's token"});
    json!({"name": "Webloop-Session", "in": "header", "required": true, "schema": schema})
}

/// The same, where a request may be without it.
fn optional_session_header() -> Value {
    let mut header = session_header();
    header["required"] = false.into();
    header
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
        (421, "to a host that the plant is not"),
        (431, "a head of more than 16 KiB or 100 lines"),
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
        let text = format!("{:#}\n", describe(None));
        if std::env::var_os("WEBLOOP_TEST_WRITE").is_some() {
            std::fs::write(path, &text).expect("the checkout can be written");
        }
        let there = std::fs::read_to_string(path).unwrap_or_default();
        assert!(there == text, "WEBLOOP_TEST_WRITE=1 writes it anew");
    }

    #[test]
    fn every_path_is_described_and_every_description_has_a_path() {
        let document = describe(None);
        let described: BTreeSet<&str> = document["paths"]
            .as_object()
            .expect("an object")
            .keys()
            .map(String::as_str)
            .collect();
        assert_eq!(described, BTreeSet::from(PATHS));
    }

    #[test]
    fn a_plant_describes_its_own_inputs_and_outputs() {
        let of = |signals, schema: &str, field: &str| {
            let document = describe(signals);
            let schema = &document["components"]["schemas"][schema]["properties"][field];
            schema["type"].as_str().map(str::to_owned)
        };
        assert_eq!(of(None, "State", "u"), None);
        for (field, one_two) in [("u", "number"), ("y", "array")] {
            let types = |signals| of(Some(signals), "State", field);
            assert_eq!(types([1, 2]).as_deref(), Some(one_two), "{field}");
            assert_ne!(types([2, 1]), types([1, 2]), "{field}");
        }
        let document = describe(Some([2, 1]));
        let u = &document["paths"]["/closed"]["get"]["parameters"][0];
        assert_eq!(
            (&u["name"], &u["schema"]["type"]),
            (&"u".into(), &"array".into())
        );
    }

    #[test]
    fn the_schemas_have_the_fields_of_the_messages() {
        let document = describe(None);
        let check = |name: &str, message: Value| {
            let fields: BTreeSet<&String> =
                message.as_object().expect("an object").keys().collect();
            let schema = &document["components"]["schemas"][name]["properties"];
            let schema = schema.as_object().expect("an object");
            let described: BTreeSet<&String> =
                schema.keys().filter(|name| *name != "crc").collect();
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
