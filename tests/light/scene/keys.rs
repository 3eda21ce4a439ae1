//! The reader of scenes and their schema know the same members of each object.

use std::collections::{BTreeMap, BTreeSet};

use landfall::report::schema::SCENE_SCHEMA;
use serde_json::{Value, json};

use crate::scene::{RIGHT, read_alone};

/// The forms that a schema of `root` permits, by their places.
fn forms<'s>(root: &'s Value, schema: &'s Value) -> BTreeMap<*const Value, &'s Value> {
    let mut forms = BTreeMap::from([(&raw const *schema, schema)]);
    let parts = ["anyOf", "oneOf"].into_iter().filter_map(|key| schema[key].as_array()).flatten();
    let named = schema["$ref"].as_str().map(|name| {
        let pointer = name.strip_prefix('#').expect("a place in the schema");
        root.pointer(pointer).expect("it is defined")
    });
    for part in parts.chain(named) {
        forms.extend(self::forms(root, part));
    }
    forms
}

struct KeyComparison<'s> {
    root: &'s Value,
    text: Value,
    /// The schemas of objects that were compared.
    compared: BTreeSet<*const Value>,
}

impl<'s> KeyComparison<'s> {
    /// Adds a member that nothing is like to each object below a path; the reader then lists those
    /// it knows.
    fn walk(&mut self, at: &str, schemas: BTreeMap<*const Value, &'s Value>) {
        let objects = schemas.iter().filter(|(_, schema)| schema["properties"].is_object());
        let objects: Vec<_> = objects.map(|(place, schema)| (*place, *schema)).collect();
        self.compared.extend(objects.iter().map(|(place, _)| place));
        let below = |key: &str, of: &str| -> BTreeMap<*const Value, &'s Value> {
            let parts = schemas.values().filter_map(|schema| match key {
                "" => schema.get(of),
                key => schema.get(of)?.get(key),
            });
            parts.flat_map(|part| forms(self.root, part)).collect()
        };
        match self.text.pointer(at).expect("it was walked to").clone() {
            Value::Object(members) => {
                if !objects.is_empty() {
                    let known =
                        objects.iter().flat_map(|(_, schema)| schema["properties"].as_object());
                    let known = known.flat_map(|properties| properties.keys().cloned());
                    let known: BTreeSet<String> = known.filter(|key| key != "$schema").collect();
                    assert_eq!(self.known(at), known, "{at}");
                }
                let below: Vec<_> =
                    members.keys().map(|key| (key, below(key, "properties"))).collect();
                below.into_iter().for_each(|(key, below)| self.walk(&format!("{at}/{key}"), below));
            }
            Value::Array(items) => {
                let below = below("", "items");
                (0..items.len()).for_each(|i| self.walk(&format!("{at}/{i}"), below.clone()));
            }
            _ => {}
        }
    }

    /// The members that the reader knows of the object at a path.
    fn known(&self, at: &str) -> BTreeSet<String> {
        let mut text = self.text.clone();
        text.pointer_mut(at).expect("it is there")["qqqqqqqqqqqqqqqq"] = json!(1);
        let reading = read_alone(&text.to_string());
        let helps = reading.diagnostics.iter().filter_map(|found| found.help.as_ref());
        let list =
            helps.filter_map(|help| help.strip_prefix("its members are ")).collect::<Vec<_>>();
        let [list] = list[..] else { panic!("{at}: {:#?}", reading.diagnostics) };
        list.split('`').skip(1).step_by(2).map(str::to_string).collect()
    }
}

/// The schemas of objects with members, wherever they stand.
fn objects(schema: &Value, found: &mut BTreeSet<*const Value>) {
    match schema {
        Value::Object(entries) => {
            if schema["properties"].is_object() && schema["type"] == "object" {
                found.insert(schema);
            }
            entries.values().for_each(|entry| objects(entry, found));
        }
        Value::Array(items) => items.iter().for_each(|item| objects(item, found)),
        _ => {}
    }
}

#[test]
fn the_reader_knows_the_members_of_the_schema_and_no_others() {
    let root: Value = serde_json::from_str(SCENE_SCHEMA).unwrap();
    let text = serde_json::from_str(RIGHT).unwrap();
    let mut comparison = KeyComparison { root: &root, text, compared: BTreeSet::new() };
    comparison.walk("", forms(&root, &root));
    let mut all = BTreeSet::new();
    objects(&root, &mut all);
    assert_eq!(
        all.difference(&comparison.compared).count(),
        0,
        "every object of the schema is compared"
    );
    assert!(all.len() > 20, "{}", all.len());
}
