//! Signals of the system: errors and words instead of a silent end, progress on request.

use std::sync::atomic::{AtomicBool, Ordering};

/// Set by SIGUSR1 until the progress is printed.
static PROGRESS_WANTED: AtomicBool = AtomicBool::new(false);

/// Prepares this process. A file that grows beyond the limit (`ulimit -f`) is an error of the write, not the end. A mapped file
/// that is cut short from outside, a disk that fails, and memory that runs out end the program with words and
/// [`super::Exit::NotWritten`]. SIGUSR1 asks for the progress and ends nothing.
#[cfg(unix)]
pub(super) fn install() {
    let handle = |signal: libc::c_int, handler: extern "C" fn(libc::c_int)| {
        // SAFETY: no other thread runs yet; the handlers call only what may be called in one.
        unsafe { libc::signal(signal, handler as *const () as libc::sighandler_t) };
    };
    handle(libc::SIGBUS, on_bus_error);
    handle(libc::SIGABRT, on_abort);
    handle(libc::SIGUSR1, on_request);
    // SAFETY: as above.
    unsafe { libc::signal(libc::SIGXFSZ, libc::SIG_IGN) };
}

#[cfg(not(unix))]
pub(super) fn install() {}

/// Whether somebody asked for the progress since the last call.
pub(super) fn progress_wanted() -> bool {
    PROGRESS_WANTED.load(Ordering::Relaxed) && PROGRESS_WANTED.swap(false, Ordering::Relaxed)
}

/// Runs `set`, which handles interrupts and hangups, and ignores hangups afterwards if they were ignored before: `nohup` asks for
/// that.
#[cfg(unix)]
pub(super) fn keep_nohup<T>(set: impl FnOnce() -> T) -> T {
    // SAFETY: the structure may be all zeros; with no new action given, the call only fills it.
    let is_ignored = unsafe {
        let mut before: libc::sigaction = std::mem::zeroed();
        libc::sigaction(libc::SIGHUP, std::ptr::null(), &raw mut before) == 0 && before.sa_sigaction == libc::SIG_IGN
    };
    let result = set();
    if is_ignored {
        // SAFETY: ignoring a signal runs no code.
        unsafe { libc::signal(libc::SIGHUP, libc::SIG_IGN) };
    }
    result
}

#[cfg(not(unix))]
pub(super) fn keep_nohup<T>(set: impl FnOnce() -> T) -> T {
    set()
}

#[cfg(unix)]
extern "C" fn on_request(_: libc::c_int) {
    PROGRESS_WANTED.store(true, Ordering::Relaxed);
}

/// A page of a mapped file cannot be had: there is nothing to return to.
#[cfg(unix)]
extern "C" fn on_bus_error(_: libc::c_int) {
    end_with(
        b"error: a file in use was cut short by another program, or its disk failed (SIGBUS); rows that ended \
before are kept: the same command goes on\n",
    );
}

/// Rust aborts where memory runs out, after a line that names the size.
#[cfg(unix)]
extern "C" fn on_abort(_: libc::c_int) {
    end_with(
        b"error: out of memory, or a defect of the program (SIGABRT); rows that ended before are kept: give fewer \
--threads or raise the limit on memory (`ulimit -v`), then run the same command again\n",
    );
}

/// Prints words and ends the program, from within a handler.
#[cfg(unix)]
fn end_with(words: &[u8]) {
    // SAFETY: both calls are allowed in a handler; the buffer lives as long as the program.
    unsafe {
        libc::write(libc::STDERR_FILENO, words.as_ptr().cast(), words.len());
        libc::_exit(super::Exit::NotWritten as libc::c_int);
    }
}
