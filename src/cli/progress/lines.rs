//! A line for each piece that has ended.

use indicatif::HumanCount;

use super::board::Board;
use super::piece::Piece;

/// The line of a piece that has ended, with what came of it.
pub fn line(board: &Board<'_>, piece: &Piece, note: &str) -> String {
    let total = board.pieces.len();
    let place = format!("[{:width$}/{total}]", board.ended(), width = total.to_string().len());
    let note = if note.is_empty() { String::new() } else { format!(": {note}") };
    let verb = if piece.error().is_some() { piece.kind.doing() } else { piece.kind.done() };
    format!("{place} {verb} {}{note} ({})", piece.name, pace(piece))
}

/// How long a piece took, and how fast it was.
fn pace(piece: &Piece) -> String {
    let time = format!("{:.1} s", piece.time().as_secs_f64());
    match piece.rate() {
        Some(rate) => format!("{time}, {} {}/s", HumanCount(rate.round() as u64), piece.kind.unit()),
        None => time,
    }
}
