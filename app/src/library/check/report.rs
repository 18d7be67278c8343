//! What a check found, for machines.

use super::{Checked, Row};
use serde_json::{Value, json};

/// Counts, rows and pairs.
pub fn json(checked: &Checked) -> Value {
    let rows: Vec<Value> = checked.rows.iter().map(json_row).collect();
    let pairs = checked.pairs.iter().map(|pair| {
        json!({ "a": pair.a.to_string_lossy(), "b": pair.b.to_string_lossy(), "kind": pair.kind.word(), "distance": pair.distance })
    });
    let pairs: Vec<Value> = pairs.collect();
    json!({ "files": checked.files, "errors": checked.errors, "warnings": checked.warnings, "rows": rows, "pairs": pairs })
}

fn json_row(row: &Row) -> Value {
    json!({
        "file": row.path.to_string_lossy(),
        "line": row.line,
        "severity": row.severity.word(),
        "kind": row.kind.word(),
        "key": row.key,
        "message": row.message,
    })
}
