//! What others may ask of a run, and what comes of it, as plain words. Root decides; how it is carried to the run and
//! back is the affair of `ambidex-http`.

mod about;
mod answer;
mod change;
mod number;
mod work;

pub use about::{About, ControllerDiagnostics};
pub use answer::{Answer, Refusal, Why, beginning};
pub use change::{WorldChange, answer};
pub use work::{Edit, NameOrId, Submission, Work};
