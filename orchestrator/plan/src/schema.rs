//! JSON schemas of experiments and plans, generated from the types that read them.
//!
//! The settings of the ends in a plan are described in `endpoint`.

use std::borrow::Cow;

use endpoint::{ControllerSettings, PageSettings};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema, schema_for};

use crate::expect::Expect;
use crate::experiment::{Block, ExperimentFile, NEEDED, Scaled, lists};
use crate::list::{List, OwnClient};
use crate::plan::Plan;

/// A kind of document that has a schema.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Document {
    /// An experiment, as TOML: `orchestrator/experiments/experiment.schema.json`.
    Experiment,
    /// A plan: `orchestrator/experiments/plan.schema.json`.
    Plan,
}

/// The JSON schema of a document, for editors and other programs. It is committed as a file.
#[must_use]
pub fn schema(document: Document) -> String {
    let schema = match document {
        Document::Experiment => schema_for!(ExperimentFile),
        Document::Plan => schema_for!(Plan),
    };
    format!("{:#}\n", schema.as_value())
}

impl JsonSchema for List {
    fn schema_name() -> Cow<'static, str> {
        "List".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "One value, or a list of them.",
            "type": ["string", "number", "array"],
            "items": { "type": ["string", "number"] }
        })
    }
}

/// A list whose items may be programs of one's own.
fn clients(generator: &mut SchemaGenerator) -> Schema {
    let own = generator.subschema_for::<OwnClient>();
    json_schema!({
        "anyOf": [
            { "type": "string" },
            own,
            { "type": "array", "items": { "anyOf": [{ "type": "string" }, own] } }
        ]
    })
}

// A block is read by hand, so its keys are described by hand.
impl JsonSchema for Block {
    fn schema_name() -> Cow<'static, str> {
        "Block".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let of_all = ControllerSettings::FIELDS
            .iter()
            .map(|field| (field.name, field.about));
        let of_pages = PageSettings::FIELDS
            .iter()
            .map(|field| (field.name, field.about));
        let lists = lists().chain(of_all).chain(of_pages);
        let mut properties: serde_json::Map<_, _> = lists
            .map(|(name, about)| {
                let mut list = match name {
                    "client" => clients(generator),
                    _ => generator.subschema_for::<List>(),
                };
                list.insert("description".to_owned(), about.into());
                (name.to_owned(), list.to_value())
            })
            .collect();
        for (name, mut schema, about) in [
            (
                "expect",
                generator.subschema_for::<Expect>(),
                "What is expected of these cells, beside what the whole experiment expects",
            ),
            (
                "repeats",
                u32::json_schema(generator),
                "How often each combination is run, each time on another realisation of the link",
            ),
            (
                "together",
                u16::json_schema(generator),
                "How many of these cells may run at a time without disturbing each other",
            ),
            (
                "scaled",
                generator.subschema_for::<Scaled>(),
                "The scaled block, which is run unless --full asks for the whole",
            ),
        ] {
            schema.insert("description".to_owned(), about.into());
            properties.insert(name.to_owned(), schema.to_value());
        }
        json_schema!({
            "description": "A block `[[cells]]`: every combination of its lists is a cell.",
            "type": "object",
            "properties": properties,
            "required": NEEDED,
            "additionalProperties": false
        })
    }
}
