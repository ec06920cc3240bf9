//! Answers checked against the published JSON Schemas.
//!
//! Of draft 2020-12 this knows the keywords that `docs/schema` uses, and refuses any other, so that
//! nothing in a schema goes unchecked. A whole validator draws in thirty crates.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;

use anyhow::{Context, Result, bail};
use serde_json::{Map, Value};

use crate::shell;

/// Keywords that say nothing of an instance.
const WORDS: [&str; 6] = ["$schema", "$id", "$defs", "title", "description", "then"];

/// The schemas of `docs/schema` by the name of their file.
pub(crate) struct Schemas {
    documents: BTreeMap<String, Value>,
}

impl Schemas {
    /// Reads all of them.
    pub(crate) fn read() -> Result<Self> {
        let folder = shell::root().join("docs/schema");
        let mut documents = BTreeMap::new();
        for entry in fs::read_dir(&folder).context("cannot read docs/schema")? {
            let path = entry?.path();
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            let text = fs::read_to_string(&path).with_context(|| name.clone())?;
            documents.insert(name.clone(), serde_json::from_str(&text).context(name)?);
        }
        Ok(Self { documents })
    }

    /// What is wrong with an answer of the form that its own key `schema` names; empty if nothing.
    pub(crate) fn mismatches(&self, answer: &Value) -> Result<Vec<String>> {
        let form = answer["schema"].as_str().unwrap_or_default();
        let name = form.strip_prefix("truing/").and_then(|f| f.split('/').next());
        let file = format!("{}.json", name.unwrap_or_default());
        let Some(schema) = self.documents.get(&file) else {
            return Ok(vec![format!("its schema `{form}` is not in docs/schema")]);
        };
        let mut found = Vec::new();
        self.check(schema, (&file, "answer"), answer, &mut found)?;
        Ok(found)
    }

    fn check(
        &self,
        schema: &Value,
        at: (&str, &str),
        instance: &Value,
        found: &mut Vec<String>,
    ) -> Result<()> {
        let (file, path) = at;
        if schema == &Value::Bool(false) {
            found.push(format!("{path} is not in the schema"));
            return Ok(());
        }
        let keywords =
            schema.as_object().with_context(|| format!("{file}: a schema is no object"))?;
        for (keyword, value) in keywords {
            if WORDS.contains(&keyword.as_str()) {
                continue;
            }
            if let Some(wrong) = of_itself(keyword, value, instance)? {
                found.extend(wrong.map(|wrong| format!("{path} {wrong}")));
            } else if !self.check_parts((keyword, value), keywords, at, instance, found)? {
                bail!("{file}: the keyword `{keyword}` is not checked by xtask");
            }
        }
        Ok(())
    }

    /// Keywords that hold schemas; whether `keyword` is one.
    fn check_parts(
        &self,
        (keyword, value): (&str, &Value),
        keywords: &Map<String, Value>,
        at: (&str, &str),
        instance: &Value,
        found: &mut Vec<String>,
    ) -> Result<bool> {
        let (file, path) = at;
        match keyword {
            "$ref" => {
                let (file, target) = self.resolve(file, value)?;
                self.check(target, (file, path), instance, found)?;
            }
            "properties" => {
                for (key, property) in object(value)? {
                    if let Some(inner) = instance.get(key) {
                        self.check(property, (file, &format!("{path}.{key}")), inner, found)?;
                    }
                }
            }
            "additionalProperties" => {
                let known = keywords.get("properties").and_then(Value::as_object);
                for (key, inner) in instance.as_object().into_iter().flatten() {
                    if known.is_none_or(|known| !known.contains_key(key)) {
                        self.check(value, (file, &format!("{path}.{key}")), inner, found)?;
                    }
                }
            }
            "unevaluatedProperties" => {
                let known = self.evaluated((file, keywords), instance)?;
                for (key, inner) in instance.as_object().into_iter().flatten() {
                    if !known.contains(key) {
                        self.check(value, (file, &format!("{path}.{key}")), inner, found)?;
                    }
                }
            }
            "items" => {
                for (n, inner) in instance.as_array().into_iter().flatten().enumerate() {
                    self.check(value, (file, &format!("{path}[{n}]")), inner, found)?;
                }
            }
            "allOf" => {
                for part in list(value)? {
                    self.check(part, at, instance, found)?;
                }
            }
            "anyOf" => {
                let mut tried = Vec::new();
                for part in list(value)? {
                    let mut wrong = Vec::new();
                    self.check(part, at, instance, &mut wrong)?;
                    tried.push(wrong);
                }
                // What the closest of them lacks, the last of several; nothing where one is met.
                found.extend(tried.into_iter().rev().min_by_key(Vec::len).unwrap_or_default());
            }
            "if" => {
                let mut unmet = Vec::new();
                self.check(value, at, instance, &mut unmet)?;
                if let (true, Some(then)) = (unmet.is_empty(), keywords.get("then")) {
                    self.check(then, at, instance, found)?;
                }
            }
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// Keys that the properties of a schema, and of those that it is made of, speak of.
    fn evaluated(
        &self,
        (file, keywords): (&str, &Map<String, Value>),
        instance: &Value,
    ) -> Result<BTreeSet<String>> {
        let own = keywords.get("properties").and_then(Value::as_object);
        let mut known: BTreeSet<String> = own.into_iter().flat_map(Map::keys).cloned().collect();
        let mut parts: Vec<(&str, &Value)> = Vec::new();
        if let Some(reference) = keywords.get("$ref") {
            parts.push(self.resolve(file, reference)?);
        }
        for part in keywords.get("allOf").map(list).transpose()?.into_iter().flatten() {
            parts.push((file, part));
        }
        if let (Some(condition), Some(then)) = (keywords.get("if"), keywords.get("then")) {
            let mut unmet = Vec::new();
            self.check(condition, (file, ""), instance, &mut unmet)?;
            parts.extend(unmet.is_empty().then_some((file, then)));
        }
        for (file, part) in parts {
            known.extend(self.evaluated((file, object(part)?), instance)?);
        }
        Ok(known)
    }

    /// The schema that `answer.json#/$defs/name` or `#/$defs/name` names, and its file.
    fn resolve<'s>(&'s self, file: &'s str, reference: &Value) -> Result<(&'s str, &'s Value)> {
        let reference = reference.as_str().context("a $ref is a text")?;
        let (other, pointer) = reference.split_once('#').unwrap_or((reference, ""));
        let name = if other.is_empty() { file } else { other };
        let (name, document) = self
            .documents
            .get_key_value(name)
            .with_context(|| format!("{file}: there is no {name}"))?;
        let target = document.pointer(pointer);
        Ok((name, target.with_context(|| format!("{file}: {reference} leads nowhere"))?))
    }
}

/// What a keyword without schemas finds wrong, one line each; `None` where it is not such a keyword.
fn of_itself(
    keyword: &str,
    value: &Value,
    instance: &Value,
) -> Result<Option<impl Iterator<Item = String>>> {
    let limit = value.as_u64();
    let one = |is_wrong: bool, wrong: String| if is_wrong { vec![wrong] } else { Vec::new() };
    let wrong = match keyword {
        "type" => one(!is_of_type(value, instance), format!("is no {value}")),
        "const" => one(value != instance, format!("is not {value}")),
        "enum" => one(!list(value)?.contains(instance), format!("is none of {value}")),
        "minimum" => {
            let is_below = instance.is_number() && instance.as_f64() < value.as_f64();
            one(is_below, format!("is below {value}"))
        }
        "minItems" => one(
            count(instance).is_some_and(|n| Some(n) < limit),
            format!("has fewer items than {value}"),
        ),
        "maxItems" => one(
            count(instance).is_some_and(|n| Some(n) > limit),
            format!("has more items than {value}"),
        ),
        "minLength" => one(
            length(instance).is_some_and(|n| Some(n) < limit),
            format!("is shorter than {value}"),
        ),
        "maxLength" => one(
            length(instance).is_some_and(|n| Some(n) > limit),
            format!("is longer than {value}"),
        ),
        "required" => {
            let keys = list(value)?.iter().filter_map(Value::as_str);
            let is_missing = |key: &&str| instance.is_object() && instance.get(*key).is_none();
            keys.filter(is_missing).map(|key| format!("lacks `{key}`")).collect()
        }
        _ => return Ok(None),
    };
    Ok(Some(wrong.into_iter()))
}

fn is_of_type(types: &Value, instance: &Value) -> bool {
    let is = |name: &str| match name {
        "object" => instance.is_object(),
        "array" => instance.is_array(),
        "string" => instance.is_string(),
        "number" => instance.is_number(),
        "integer" => instance.is_u64() || instance.is_i64(),
        "boolean" => instance.is_boolean(),
        "null" => instance.is_null(),
        _ => false,
    };
    match types {
        Value::String(name) => is(name),
        Value::Array(names) => names.iter().filter_map(Value::as_str).any(is),
        _ => false,
    }
}

fn list(value: &Value) -> Result<&Vec<Value>> {
    value.as_array().with_context(|| format!("expected a list, found {value}"))
}

fn object(value: &Value) -> Result<&Map<String, Value>> {
    value.as_object().with_context(|| format!("expected an object, found {value}"))
}

fn count(instance: &Value) -> Option<u64> {
    u64::try_from(instance.as_array()?.len()).ok()
}

fn length(instance: &Value) -> Option<u64> {
    u64::try_from(instance.as_str()?.chars().count()).ok()
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn wrong(schema: &Value, answer: &Value) -> Vec<String> {
        let part = json!({ "$defs": { "n": { "type": "number", "minimum": 0 } } });
        let documents = [("t.json".to_owned(), schema.clone()), ("part.json".to_owned(), part)];
        Schemas { documents: documents.into() }.mismatches(answer).unwrap()
    }

    #[test]
    fn what_an_answer_lacks_is_named_with_its_place() {
        let schema = json!({
            "type": "object", "required": ["a", "b"],
            "properties": {
                "a": { "type": "array", "maxItems": 2, "items": { "$ref": "part.json#/$defs/n" } },
                "b": { "anyOf": [{ "type": "null" }, { "type": "object", "required": ["c"] }] },
                "k": { "enum": ["x", "y"] }
            },
            "allOf": [{ "if": { "properties": { "k": { "const": "x" } } }, "then": { "required": ["z"] } }]
        });
        let of = |mut answer: Value| {
            answer["schema"] = json!("truing/t/1");
            wrong(&schema, &answer)
        };
        assert_eq!(of(json!({ "a": [1, 2.5], "b": null, "k": "y", "more": 1 })), [""; 0]);
        assert_eq!(of(json!({ "a": [1, -1], "b": null, "k": "y" })), ["answer.a[1] is below 0"]);
        assert_eq!(
            of(json!({ "a": ["1"], "b": null, "k": "y" })),
            ["answer.a[0] is no \"number\""]
        );
        assert_eq!(of(json!({ "a": [], "b": {}, "k": "y" })), ["answer.b lacks `c`"]);
        assert_eq!(of(json!({ "a": [], "b": null, "k": "x" })), ["answer lacks `z`"]);
        assert_eq!(of(json!({ "a": [], "b": null, "k": "q" })).len(), 1);
        assert_eq!(of(json!({ "a": [1, 2, 3], "k": "y" })).len(), 2);
    }

    #[test]
    fn keys_that_no_schema_lists_are_named() {
        let schema = json!({
            "allOf": [
                { "properties": { "schema": {} } },
                { "if": { "properties": { "k": { "const": "x" } } }, "then": { "properties": { "z": {} } } }
            ],
            "properties": {
                "k": {},
                "a": { "properties": { "b": {} }, "additionalProperties": false }
            },
            "unevaluatedProperties": false
        });
        let of = |mut answer: Value| {
            answer["schema"] = json!("truing/t/1");
            wrong(&schema, &answer)
        };
        assert_eq!(of(json!({ "k": "x", "z": 1, "a": { "b": 1 } })), [""; 0]);
        assert_eq!(of(json!({ "k": "y", "z": 1 })), ["answer.z is not in the schema"]);
        assert_eq!(of(json!({ "k": "y", "a": { "c": 1 } })), ["answer.a.c is not in the schema"]);
    }

    #[test]
    fn forms_and_keywords_that_are_not_known_are_not_passed_over() {
        assert_eq!(wrong(&json!({}), &json!({ "schema": "truing/u/1" })).len(), 1);
        let documents = [("t.json".to_owned(), json!({ "pattern": "^a" }))].into();
        let answer = json!({ "schema": "truing/t/1" });
        assert!(Schemas { documents }.mismatches(&answer).is_err());
    }

    #[test]
    fn the_published_schemas_are_of_known_keywords_and_references() {
        let schemas = Schemas::read().unwrap();
        for (file, document) in &schemas.documents {
            walk(&schemas, file, document);
            // Every form is closed, so that no key goes unlisted.
            let is_form = document["properties"].get("schema").is_some();
            assert_eq!(is_form, document["unevaluatedProperties"] == json!(false), "{file}");
            assert_closed(file, document, is_form);
        }
        assert!(schemas.documents.len() >= 6);
    }

    /// Asserts that objects with properties of their own list all of them.
    fn assert_closed(at: &str, schema: &Value, is_composed: bool) {
        let Some(keywords) = schema.as_object() else { return };
        let is_object = schema["type"] == "object" || schema["type"] == json!(["object", "null"]);
        // The header is a part of every form, and estimates are as the kind has them.
        let is_part = is_composed || at.ends_with("header") || at.ends_with(".estimates");
        let is_closed = schema.get("additionalProperties").is_some();
        assert!(!is_object || is_part || is_closed, "{at} does not say that it lists all keys");
        for key in ["properties", "$defs"] {
            for (name, inner) in keywords.get(key).and_then(Value::as_object).into_iter().flatten()
            {
                assert_closed(&format!("{at}.{name}"), inner, false);
            }
        }
        for key in ["allOf", "anyOf"] {
            for inner in keywords.get(key).and_then(Value::as_array).into_iter().flatten() {
                assert_closed(at, inner, is_composed);
            }
        }
        if let Some(items) = keywords.get("items") {
            assert_closed(&format!("{at}[]"), items, false);
        }
    }

    /// Checks every schema within a schema against an instance that meets none of it.
    fn walk(schemas: &Schemas, file: &str, schema: &Value) {
        schemas.check(schema, (file, ""), &Value::Null, &mut Vec::new()).unwrap();
        for key in ["properties", "$defs"] {
            for inner in schema[key].as_object().into_iter().flatten() {
                walk(schemas, file, inner.1);
            }
        }
        for key in ["allOf", "anyOf"] {
            for inner in schema[key].as_array().into_iter().flatten() {
                walk(schemas, file, inner);
            }
        }
        for key in ["items", "then"] {
            if let Some(inner) = schema.get(key) {
                walk(schemas, file, inner);
            }
        }
    }

    /// On the example of a part, with a tool and a program.
    #[test]
    fn what_the_documents_ask_for_has_its_published_form() {
        let truing = crate::program::Truing::beside_the_tests().unwrap();
        let folder = shell::root().join("target/depth-test");
        let _ = fs::remove_dir_all(&folder);
        let path = folder.to_str().unwrap();
        assert_eq!(truing.run(&["init", "pose-icp", path]).unwrap().code, Some(0));
        let case = folder.join("case.toml");
        let text = fs::read_to_string(&case).unwrap();
        fs::write(&case, text + "\n[tool]\nfilm_mm = 2.0\nremoval_exponent = 1.0\n").unwrap();
        let program = folder.join("part.ngc");
        fs::write(&program, "G21 G90\nG1 X0 Y0 Z1 F100\nG1 X1\n").unwrap();
        let touched = shell::root().join("target/guide-test");
        let _ = fs::remove_dir_all(&touched);
        let touched_path = touched.to_str().unwrap();
        assert_eq!(truing.run(&["init", "probe-comp", touched_path]).unwrap().code, Some(0));
        let words = ["depth", path, program.to_str().unwrap(), "--json"];
        let all = [
            words.to_vec(),
            [&words[..], &["--planned", "0,0,0.1,0,0,0"]].concat(),
            vec!["itlicp", path, "--fine", "0.1", "--tolerance", "0.1", "--json"],
            vec!["design", "micro-plane", "--curvatures", "0.02,0", "--json"],
            vec!["guide", touched_path, "--json"],
        ];
        for words in all {
            let answer = truing.run(&words).unwrap();
            assert_eq!(answer.code, Some(0), "{}", answer.message);
            let wrong = Schemas::read().unwrap().mismatches(&answer.json).unwrap();
            assert_eq!(wrong, Vec::<String>::new());
        }
    }
}
