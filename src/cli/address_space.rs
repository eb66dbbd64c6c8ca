//! Address space of this process where the system limits it (`ulimit -v`, batch systems).

/// Share of a limited address space that the allocator may reserve ahead.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
const SHARE: u64 = 8;
/// Address space that glibc reserves for an arena (64-bit systems).
#[cfg(all(target_os = "linux", target_env = "gnu"))]
const ARENA_BYTES: u64 = 64 << 20;

/// Bounds the arenas of glibc's allocator. It reserves one per thread, up to eight per core, before the threads have used any
/// memory: under a limit nothing is left for their stacks and buffers. Without a limit the default stays.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
pub(super) fn bound() {
    let mut limit = libc::rlimit { rlim_cur: libc::RLIM_INFINITY, rlim_max: libc::RLIM_INFINITY };
    // SAFETY: the call fills the structure, which lives long enough.
    let known = unsafe { libc::getrlimit(libc::RLIMIT_AS, &raw mut limit) } == 0;
    if known && limit.rlim_cur != libc::RLIM_INFINITY {
        let arenas = (limit.rlim_cur / SHARE / ARENA_BYTES).clamp(1, 1024);
        // SAFETY: the call only sets a number of the allocator; no other thread runs yet.
        unsafe { libc::mallopt(libc::M_ARENA_MAX, arenas as libc::c_int) };
    }
}

#[cfg(not(all(target_os = "linux", target_env = "gnu")))]
pub(super) fn bound() {}
