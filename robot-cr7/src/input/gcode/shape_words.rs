//! The words of arcs and splines.

use nalgebra::Vector3;

use super::arc::ArcForm;
use super::block::Block;
use super::fault::{GcodeFault, Located};
use super::modal::Modal;

/// The form of the arc `code` (in tenths) from `position`, from I J K or R.
pub(super) fn arc_form(
    block: &mut Block,
    modal: &Modal,
    position: Vector3<f64>,
    code: u16,
) -> Result<ArcForm, Located> {
    let radius = block.take(b'r');
    let [first, second, along] = modal.plane.axes();
    let letters = b"ijk";
    if let Some(word) = block.word(letters[along]) {
        let needs = "the centre of an arc has no offset along the axis of its plane";
        return Err(word.fault(GcodeFault::Missing { needs, remedy: "remove the word or select another plane" }));
    }
    let offsets = [block.take(letters[first]), block.take(letters[second])];
    match (radius, offsets) {
        (Some(word), [None, None]) => Ok(ArcForm::Radius(modal.unit.to_metres(word.value))),
        (Some(word), _) => {
            let rule = "an arc has either R or I, J and K";
            Err(word.fault(GcodeFault::Syntax { rule, remedy: "remove one of the two" }))
        }
        (None, [None, None]) => {
            let needs = "an arc needs its centre or its radius";
            Err(block.code_fault(code, GcodeFault::Missing { needs, remedy: "write I, J, K or R" }))
        }
        (None, [Some(_), None] | [None, Some(_)]) if modal.absolute_centres => {
            let needs = "after G90.1 an arc needs both coordinates of its centre";
            Err(block.code_fault(code, GcodeFault::Missing { needs, remedy: "write both, or G91.1" }))
        }
        (None, offsets) => {
            let mut centre = if modal.absolute_centres { Vector3::zeros() } else { position };
            for (axis, offset) in [first, second].into_iter().zip(offsets) {
                centre[axis] += offset.map_or(0.0, |word| modal.unit.to_metres(word.value));
            }
            Ok(ArcForm::Centre(centre))
        }
    }
}

/// Control points of G5 and the offset of the first inner one of a G5 that continues it.
pub(super) fn cubic(
    block: &mut Block,
    modal: &Modal,
    (start, to): (Vector3<f64>, Vector3<f64>),
    continuation: Option<Vector3<f64>>,
) -> Result<(Vec<Vector3<f64>>, Vector3<f64>), Located> {
    let missing = |needs, remedy| Err(block.code_fault(50, GcodeFault::Missing { needs, remedy }));
    let first = match (block.word(b'i'), block.word(b'j')) {
        (Some(_), Some(_)) => None,
        (None, None) => match continuation {
            Some(offset) => Some(offset),
            None => return missing("the first G5 of a series needs I and J", "write I and J"),
        },
        _ => return missing("G5 has both I and J, or neither", "write both"),
    };
    if block.word(b'p').is_none() || block.word(b'q').is_none() {
        return missing("G5 needs P and Q", "write the offset of the second control point from the end");
    }
    let first = first.unwrap_or_else(|| flat(block, modal, b"ij"));
    let second = flat(block, modal, b"pq");
    Ok((vec![start, start + first, to + second, to], -second))
}

/// Control points of G5.1.
pub(super) fn quadratic(
    block: &mut Block,
    modal: &Modal,
    (start, to): (Vector3<f64>, Vector3<f64>),
) -> Result<Vec<Vector3<f64>>, Located> {
    let offset = flat(block, modal, b"ij");
    if offset == Vector3::zeros() {
        let needs = "G5.1 needs I or J other than 0";
        return Err(
            block.code_fault(51, GcodeFault::Missing { needs, remedy: "write the offset of its control point" })
        );
    }
    Ok(vec![start, start + offset, to])
}

/// A vector of the XY plane from two words, 0 where one is missing.
fn flat(block: &mut Block, modal: &Modal, letters: &[u8; 2]) -> Vector3<f64> {
    let mut component = |letter| block.take(letter).map_or(0.0, |word| modal.unit.to_metres(word.value));
    Vector3::new(component(letters[0]), component(letters[1]), 0.0)
}

/// Refuses words with these letters.
pub(super) fn refuse_axes(block: &Block, letters: &[u8], needs: &'static str) -> Result<(), Located> {
    match letters.iter().find_map(|&letter| block.word(letter)) {
        Some(word) => Err(word.fault(GcodeFault::Missing { needs, remedy: "remove the word" })),
        None => Ok(()),
    }
}
