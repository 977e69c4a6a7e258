//! Ctrl-C and its relatives: the first cancels, the second ends the process, whatever it is doing.

use std::io;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use ambidex::runtime::Control;
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::flag;
use tokio::signal::unix::{Signal, SignalKind, signal};
use tokio::sync::mpsc;

use crate::exit::Exit;

/// What ends a process that is told to end.
const ENDING: [i32; 3] = [SIGINT, SIGTERM, SIGHUP];

/// The second of these signals ends the process at once, from within the signal itself: nothing that blocks delays it.
///
/// # Errors
/// When the handlers cannot be set.
pub fn end_on_the_second() -> io::Result<()> {
    let is_told = Arc::new(AtomicBool::new(false));
    for ending in ENDING.into_iter().filter(|ending| *ending != SIGHUP || hears_hang_up()) {
        // In this order: the first one finds the flag down.
        flag::register_conditional_shutdown(ending, Exit::Canceled as i32, Arc::clone(&is_told))?;
        flag::register(ending, Arc::clone(&is_told))?;
    }
    Ok(())
}

/// The first of these signals cancels the mission, the second ends the process at once. Children die with the process;
/// shared memory is swept at the next start.
///
/// # Errors
/// When the handlers cannot be set.
pub fn cancel_on_signals(run: mpsc::UnboundedSender<Control>) -> io::Result<impl Future<Output = ()>> {
    end_on_the_second()?;
    let mut interrupt = signal(SignalKind::interrupt())?;
    let mut terminate = signal(SignalKind::terminate())?;
    let mut hang_up = hears_hang_up().then(|| signal(SignalKind::hangup())).transpose()?;
    Ok(async move {
        tokio::select! {
            _ = interrupt.recv() => {}
            _ = terminate.recv() => {}
            () = heard(hang_up.as_mut()) => {}
        }
        drop(run.send(Control::Cancel));
    })
}

async fn heard(signal: Option<&mut Signal>) {
    match signal {
        Some(signal) => drop(signal.recv().await),
        None => std::future::pending().await,
    }
}

/// Whether the terminal's going is to be heard: who started the process with `nohup` wants it to stay.
fn hears_hang_up() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let ignored = ignored.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or_default();
    ignored & (1 << (SIGHUP - 1)) == 0
}
