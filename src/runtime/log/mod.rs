//! The journal as a file: where it lies, writing it, following it while it is written; tracing events made from records.

mod disk;
mod file;
mod follower;
mod held;
mod keep;
mod path;
mod trace;

pub use file::JournalFile;
pub use follower::{Follower, News};
pub use held::is_being_written;
pub use keep::make_room;
pub use path::{default_folder, default_path, instances};
pub(crate) use trace::diagnosed;
pub use trace::emit;
