//! Documents of MaterialX as other programs write them.

use burnish_material::Value;
use burnish_material::exchange::materialx::{ReadMaterial, read};

/// A document with a surface whose inputs these are, and with what stands before it.
pub fn document(surface: &str, attributes: &str, before: &str, inputs: &str) -> String {
    format!(
        "<?xml version=\"1.0\"?><materialx version=\"1.39\" {attributes}>{before}<{surface} name=\"s\" type=\"surfaceshader\">{inputs}</{surface}>
         <surfacematerial name=\"m\" type=\"material\"><input name=\"surfaceshader\" type=\"surfaceshader\" nodename=\"s\" /></surfacematerial>
         </materialx>"
    )
}

pub fn one(text: &str) -> ReadMaterial {
    let mut all = read(text).unwrap_or_else(|error| panic!("{error}\n{text}"));
    assert_eq!(all.len(), 1);
    assert_eq!(read(text).as_deref(), Ok(all.as_slice()), "read twice");
    all.remove(0)
}

pub fn open_pbr(before: &str, inputs: &str) -> ReadMaterial {
    one(&document("open_pbr_surface", "colorspace=\"lin_rec709\"", before, inputs))
}

/// The base colour of a graph whose output is the node `o`.
pub fn color(nodes: &str) -> ReadMaterial {
    let graph = format!("<nodegraph name=\"g\">{nodes}<output name=\"out\" type=\"color3\" nodename=\"o\" /></nodegraph>");
    open_pbr(&graph, "<input name=\"base_color\" type=\"color3\" nodegraph=\"g\" output=\"out\" />")
}

/// The roughness of a graph whose output is the node `o`.
pub fn number(nodes: &str) -> ReadMaterial {
    let graph = format!("<nodegraph name=\"g\">{nodes}<output name=\"out\" type=\"float\" nodename=\"o\" /></nodegraph>");
    open_pbr(&graph, "<input name=\"specular_roughness\" type=\"float\" nodegraph=\"g\" output=\"out\" />")
}

pub fn node(tag: &str, name: &str, kind: &str, inputs: &[(&str, &str, &str)]) -> String {
    let inputs: String = inputs
        .iter()
        .map(|(name, kind, value)| match value.strip_prefix('@') {
            Some(node) => match node.split_once('.') {
                Some((node, output)) => {
                    format!("<input name=\"{name}\" type=\"{kind}\" nodename=\"{node}\" output=\"{output}\" />")
                }
                None => format!("<input name=\"{name}\" type=\"{kind}\" nodename=\"{node}\" />"),
            },
            None => format!("<input name=\"{name}\" type=\"{kind}\" value=\"{value}\" />"),
        })
        .collect();
    format!("<{tag} name=\"{name}\" type=\"{kind}\">{inputs}</{tag}>")
}

pub fn near(value: Value, expected: &[f64]) -> bool {
    value.numbers().len() == expected.len() && value.numbers().iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6)
}
