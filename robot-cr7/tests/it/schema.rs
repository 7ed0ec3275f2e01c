//! Reports against the schema that `cr7 schema` prints. `tests/readers/reports.py` does so for all commands by a validator of others.

use std::collections::BTreeSet;

use robot_cr7::ReportHead;
use serde_json::{Map, Value, json};

use crate::common::Desk;

/// The part of JSON schema that the schema of the reports uses; another keyword is refused, so that none is passed over.
struct Schema {
    root: Value,
}

type Object = Map<String, Value>;

impl Schema {
    /// The keys of an object that `schema` knows, or what is wrong with `value`.
    fn check(&self, schema: &Value, value: &Value) -> Result<BTreeSet<String>, String> {
        let schema = schema.as_object().expect("an object");
        let mut known = BTreeSet::new();
        for (word, rule) in schema {
            known.extend(self.check_word(word, rule, value).map_err(|why| format!("{word}: {why}"))?);
        }
        let closed = ["additionalProperties", "unevaluatedProperties"].iter().any(|word| schema.contains_key(*word));
        match value.as_object().and_then(|object| object.keys().find(|key| !known.contains(*key))) {
            Some(key) if closed => Err(format!("{key} is not known")),
            _ => Ok(known),
        }
    }

    fn check_word(&self, word: &str, rule: &Value, value: &Value) -> Result<BTreeSet<String>, String> {
        let nothing = BTreeSet::new();
        let test = |holds: bool| if holds { Ok(nothing) } else { Err(format!("{value} against {rule}")) };
        let list = || rule.as_array().expect("a list");
        match word {
            "$schema" | "title" | "description" | "$defs" => Ok(BTreeSet::new()),
            "additionalProperties" | "unevaluatedProperties" => {
                assert_eq!(rule, &json!(false), "{word}");
                Ok(BTreeSet::new())
            }
            "$ref" => {
                let place = rule.as_str().and_then(|text| text.strip_prefix('#')).expect("a place in the schema");
                self.check(self.root.pointer(place).expect("a definition"), value)
            }
            "type" => test(names(rule).iter().any(|name| is_a(value, name))),
            "const" => test(value == rule),
            "enum" => test(list().contains(value)),
            "minimum" => test(value.as_f64().is_none_or(|v| v >= rule.as_f64().expect("a number"))),
            "minItems" => test(value.as_array().is_none_or(|v| v.len() as u64 >= rule.as_u64().expect("a number"))),
            "maxItems" => test(value.as_array().is_none_or(|v| v.len() as u64 <= rule.as_u64().expect("a number"))),
            "required" => {
                let has = |object: &Object| names(rule).iter().all(|key| object.contains_key(*key));
                test(value.as_object().is_none_or(has))
            }
            "properties" => self.check_properties(rule.as_object().expect("an object"), value),
            "items" => {
                value.as_array().into_iter().flatten().try_for_each(|item| self.check(rule, item).map(drop))?;
                Ok(BTreeSet::new())
            }
            "prefixItems" => {
                let mut pairs = list().iter().zip(value.as_array().into_iter().flatten());
                pairs.try_for_each(|(rule, item)| self.check(rule, item).map(drop))?;
                Ok(BTreeSet::new())
            }
            "anyOf" | "oneOf" => {
                let results: Vec<_> = list().iter().map(|rule| self.check(rule, value)).collect();
                let fits = results.iter().filter(|result| result.is_ok()).count();
                if fits == 0 || word == "oneOf" && fits > 1 {
                    return Err(format!("{fits} fit: {results:?}"));
                }
                Ok(results.into_iter().flatten().flatten().collect())
            }
            _ => panic!("{word} is not a keyword that this validator knows"),
        }
    }

    fn check_properties(&self, rules: &Object, value: &Value) -> Result<BTreeSet<String>, String> {
        for (key, value) in value.as_object().into_iter().flatten() {
            if let Some(rule) = rules.get(key) {
                self.check(rule, value).map_err(|why| format!("{key}: {why}"))?;
            }
        }
        Ok(rules.keys().cloned().collect())
    }
}

/// A name or a list of names.
fn names(rule: &Value) -> Vec<&str> {
    match rule {
        Value::Array(all) => all.iter().map(|name| name.as_str().expect("a name")).collect(),
        one => vec![one.as_str().expect("a name")],
    }
}

fn is_a(value: &Value, name: &str) -> bool {
    match name {
        "object" => value.is_object(),
        "array" => value.is_array(),
        "string" => value.is_string(),
        "number" => value.is_number(),
        "integer" => value.is_i64() || value.is_u64(),
        "boolean" => value.is_boolean(),
        "null" => value.is_null(),
        _ => panic!("{name} is not a type"),
    }
}

#[test]
fn reports_have_the_keys_of_the_schema_and_no_others() {
    let desk = Desk::new("schema");
    assert_eq!(desk.run(&["schema"]).done().stdout, ReportHead::SCHEMA);
    let schema = Schema { root: serde_json::from_str(ReportHead::SCHEMA).expect("JSON") };
    desk.write("line.csv", "x_mm,y_mm\n0,0\n60,0\n120,0\n");
    desk.write("job.toml", "[path]\nfile = \"line.csv\"\n");
    for words in [
        &["plan", "--job", "job.toml", "--bound"][..],
        &["compare", "job.toml"],
        &["advise", "job.toml", "--robot", "ur5e"],
        &["place", "line.csv", "--z-mm", "-30", "--count", "2"],
    ] {
        let report = desk.run(&[words, &["--json"]].concat()).done().json();
        schema.check(&schema.root, &report).unwrap_or_else(|why| panic!("{words:?}: {why}"));
        assert_eq!((&report["command"], &report["format"]), (&json!(words[0]), &json!("report/1")));
        for key in report.as_object().expect("an object").keys() {
            let mut less = report.clone();
            less.as_object_mut().expect("an object").remove(key);
            // Of these a report has those that say something.
            if !["bound", "fit", "program", "stream", "vibration", "thermal"].contains(&key.as_str()) {
                assert!(schema.check(&schema.root, &less).is_err(), "{words:?}: without {key}");
            }
        }
        let mut other = report.clone();
        other["surprise"] = json!(1);
        assert!(schema.check(&schema.root, &other).is_err(), "{words:?}: a key that is not known");
        for list in ["entries", "costs", "frames", "limits"] {
            if report[list].is_array() {
                let mut other = report.clone();
                other[list][0]["surprise"] = json!(1);
                assert!(schema.check(&schema.root, &other).is_err(), "{words:?}: a key that is not known in {list}");
            }
        }
    }
}
