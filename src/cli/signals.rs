//! Signals by which the system ends programs that write files: turned into errors, or at least into words.

/// Prepares this process: a file that grows beyond the limit (`ulimit -f`) is an error of the write, not the end; a mapped file
/// that is cut short from outside, or whose disk fails, ends the program with words and [`super::Exit::NotWritten`].
#[cfg(unix)]
pub(super) fn install() {
    // SAFETY: no other thread runs yet; the handler calls only what may be called in one.
    unsafe {
        libc::signal(libc::SIGXFSZ, libc::SIG_IGN);
        libc::signal(libc::SIGBUS, on_bus_error as *const () as libc::sighandler_t);
    }
}

#[cfg(not(unix))]
pub(super) fn install() {}

/// A page of a mapped file cannot be had: there is nothing to return to.
#[cfg(unix)]
extern "C" fn on_bus_error(_: libc::c_int) {
    const WORDS: &[u8] =
        b"decore: a file in use was cut short by another program, or its disk failed (SIGBUS); rows that ended \
before are kept: the same command goes on\n";
    // SAFETY: both calls are allowed in a handler; the buffer lives as long as the program.
    unsafe {
        libc::write(libc::STDERR_FILENO, WORDS.as_ptr().cast(), WORDS.len());
        libc::_exit(super::Exit::NotWritten as libc::c_int);
    }
}
