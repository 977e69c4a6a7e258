//! Hostile peers: a process that speaks the wire as a controller, and lies. Whatever it does, the daemon answers as
//! `docs/wire.md` says, the mission comes to a right end, and nothing is left.
//!
//! The hostile process is this test binary in another role; what it does has a name in `acts`.

mod acts;
mod calls;
mod floods;
mod lies;
mod order;
mod peer;
mod scene;
mod segments;
mod silence;
mod strangers;
