//! Errors as Python exceptions, with fields.

use arcfeed_interp::PlanError as Unplanned;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use robot_cr7::Cr7Error;

pyo3::create_exception!(
    arcfeed,
    ArcfeedError,
    PyValueError,
    "Base of the errors of arcfeed. Its text names the place, the value, the rule and the way out."
);
pyo3::create_exception!(arcfeed, InputError, ArcfeedError, "A file, a key, an argument or an arm that cannot be used.");
pyo3::create_exception!(
    arcfeed,
    PlanError,
    ArcfeedError,
    "A motion that cannot be made. Fields: kind (\"path\", \"limit\", \"speed\", \"unverified\", \"compile\", \"other\"), s (place on the path, \
     m, or None), tool (tool point there, m, or None), limit (its name, or None), ratio (value over limit, or None)."
);

/// An error of the input, from its text.
pub fn input(error: impl std::fmt::Display) -> PyErr {
    InputError::new_err(error.to_string())
}

/// An error of planning, from what it is about.
pub fn unplanned(text: String, source: &Unplanned) -> PyErr {
    let (kind, exceeded) = match source {
        Unplanned::Path(_) => ("path", None),
        Unplanned::Limit(_) => ("limit", None),
        Unplanned::Speed(_) => ("speed", None),
        Unplanned::Unverified { limit, ratio, .. } => ("unverified", Some((limit.to_string(), *ratio))),
        _ => ("other", None),
    };
    let place = source.place();
    with_fields(text, kind, place.map(|place| (place.s, place.tool)), exceeded)
}

/// An error of planning of another kind, with no place.
pub fn undone(kind: &'static str, error: impl std::fmt::Display) -> PyErr {
    with_fields(error.to_string(), kind, None, None)
}

fn with_fields(
    text: String,
    kind: &str,
    place: Option<(f64, Option<[f64; 3]>)>,
    exceeded: Option<(String, f64)>,
) -> PyErr {
    Python::attach(|py| {
        let error = PlanError::new_err(text);
        let value = error.value(py);
        let (limit, ratio) = exceeded.unzip();
        let set = value
            .setattr("kind", kind)
            .and_then(|()| value.setattr("s", place.map(|place| place.0)))
            .and_then(|()| value.setattr("tool", place.and_then(|place| place.1)))
            .and_then(|()| value.setattr("limit", limit))
            .and_then(|()| value.setattr("ratio", ratio));
        match set {
            Ok(()) => error,
            Err(other) => other,
        }
    })
}

/// An error of the library as an exception.
pub fn raised(error: Cr7Error) -> PyErr {
    let text = error.to_string();
    match &error {
        Cr7Error::Plan { source, .. } => unplanned(text, source),
        Cr7Error::Compile { .. } => undone("compile", text),
        Cr7Error::Configuration { .. } | Cr7Error::Unsuited { .. } | Cr7Error::TooManySamples { .. } => {
            undone("other", text)
        }
        _ => input(text),
    }
}
