//! Validates JSON against the part of JSON Schema (draft 2020-12) that our schema uses.

use serde_json::Value;

/// Returns the violations of the schema, each with its path. Panics at an unsupported keyword.
///
/// Stricter than the draft: an object may only have the fields that its schema lists, so that all are described.
pub(crate) fn broken(schema: &Value, value: &Value) -> Vec<String> {
    let mut broken = Vec::new();
    check(schema, schema, value, "report", &mut broken);
    broken
}

fn check(root: &Value, schema: &Value, value: &Value, place: &str, broken: &mut Vec<String>) {
    let mut require = |holds: bool, rule: String| {
        if !holds {
            broken.push(format!("{place}: {rule}"));
        }
    };
    for (keyword, rule) in schema.as_object().expect("a schema") {
        let limit = || rule.as_f64().expect("a number");
        let length = || value.as_array().map_or(0, Vec::len) as f64;
        match &**keyword {
            "$schema" | "$defs" | "title" | "description" => {}
            "type" => require(is_of_type(value, rule), format!("is no {rule}: {value}")),
            "enum" => require(list(rule).contains(value), format!("is none of {rule}: {value}")),
            "minimum" => require(value.as_f64() >= Some(limit()), format!("below {rule}: {value}")),
            "maximum" => require(value.as_f64() <= Some(limit()), format!("above {rule}: {value}")),
            "minItems" => require(length() >= limit(), format!("shorter than {rule}")),
            "maxItems" => require(length() <= limit(), format!("longer than {rule}")),
            "required" => list(rule).iter().for_each(|field| {
                let field = field.as_str().expect("a name");
                require(value.get(field).is_some(), format!("has no {field}"));
            }),
            "properties" | "additionalProperties" | "items" | "$ref" | "oneOf" => {}
            other => panic!("the keyword {other} is not known here"),
        }
    }
    if let Some(target) = schema["$ref"].as_str() {
        let target = root
            .pointer(target.trim_start_matches('#'))
            .expect("a definition");
        check(root, target, value, place, broken);
    }
    if let Some(choices) = schema["oneOf"].as_array() {
        let of = |choice| {
            let mut broken = Vec::new();
            check(root, choice, value, place, &mut broken);
            broken
        };
        let all: Vec<Vec<String>> = choices.iter().map(of).collect();
        if all.iter().filter(|broken| broken.is_empty()).count() != 1 {
            broken.push(format!("{place}: fits not one of {}: {all:?}", all.len()));
        }
    }
    for (number, element) in value.as_array().into_iter().flatten().enumerate() {
        if let Some(items) = schema.get("items") {
            check(root, items, element, &format!("{place}[{number}]"), broken);
        }
    }
    for (field, element) in value.as_object().into_iter().flatten() {
        let place = format!("{place}.{field}");
        match schema["properties"]
            .get(field)
            .or(schema.get("additionalProperties"))
        {
            Some(schema) => check(root, schema, element, &place, broken),
            None if schema["type"] == "object" => broken.push(format!("{place}: is not in the schema")),
            None => {}
        }
    }
}

fn list(rule: &Value) -> &[Value] {
    rule.as_array().expect("a list")
}

fn is_of_type(value: &Value, name: &Value) -> bool {
    match name.as_str().expect("a type") {
        "object" => value.is_object(),
        "array" => value.is_array(),
        "string" => value.is_string(),
        "number" => value.is_number(),
        "integer" => value.is_u64() || value.is_i64(),
        "boolean" => value.is_boolean(),
        other => panic!("the type {other} is not known here"),
    }
}
