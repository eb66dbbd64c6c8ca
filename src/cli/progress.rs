//! Tells how far a batch is: a bar on a terminal, plain lines elsewhere.

use std::fmt;
use std::io::{self, IsTerminal, Write};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use console::Term;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use decore_model::run::RowStatus;

/// Default time between two plain lines.
pub(super) const DEFAULT_INTERVAL: Duration = Duration::from_secs(60);
/// Hours for which the last line forecasts.
const NIGHT_HOURS: f64 = 8.0;
/// Layouts by the columns from which on there is room for them, and the columns before the text. On a narrow terminal the figures are
/// more important than the bar.
const LAYOUTS: [(u16, &str, usize); 3] = [
    (100, "{bar:24} {percent:>3} %  {wide_msg}", 32),
    (76, "{bar:10} {percent:>3} %  {wide_msg}", 18),
    (0, "{wide_msg}", 0),
];

/// Progress of a batch: rows done, failed, rows per second, time left.
pub(super) struct Progress {
    rows: u64,
    /// Rows done before this run.
    before: u64,
    // Counted by the threads that run rows, which do nothing else here.
    done: AtomicU64,
    failed: AtomicU64,
    display: Mutex<Display>,
    started: Instant,
}

enum Display {
    Bar {
        bar: ProgressBar,
        /// Columns for the text.
        columns: usize,
    },
    Lines {
        sink: Box<dyn Write + Send>,
        interval: Duration,
        /// When the last line was written, from the start.
        last: Duration,
    },
}

impl Progress {
    /// A bar if stderr is a terminal, else plain lines to stderr at most every `interval`.
    ///
    /// `rows` is the number of rows of the whole; see [`Progress::resumed`].
    pub fn to_stderr(rows: u64, interval: Duration) -> Self {
        if io::stderr().is_terminal() {
            Self::bar(rows, ProgressDrawTarget::stderr(), Term::stderr().size().1)
        } else {
            Self::lines(rows, interval, Box::new(io::stderr()))
        }
    }

    /// Plain lines without control characters at most every `interval`, and a last one at the end.
    pub fn lines(rows: u64, interval: Duration, sink: Box<dyn Write + Send>) -> Self {
        Self::new(rows, Display::Lines { sink, interval, last: Duration::ZERO })
    }

    /// A bar on the given target, which has so many columns; on a narrow one figures alone, the more important first.
    pub fn bar(rows: u64, target: ProgressDrawTarget, columns: u16) -> Self {
        let bar = ProgressBar::with_draw_target(Some(rows), target);
        let layout = LAYOUTS.iter().find(|(least, ..)| columns >= *least);
        let (_, layout, before) = layout.copied().unwrap_or_default();
        // The layouts are constants that tests draw; should one be refused, indicatif's own does.
        if let Ok(style) = ProgressStyle::with_template(layout) {
            bar.set_style(style);
        }
        Self::new(rows, Display::Bar { bar, columns: usize::from(columns).saturating_sub(before) })
    }

    fn new(rows: u64, display: Display) -> Self {
        let [done, failed] = [0, 0].map(AtomicU64::new);
        Self { rows, before: 0, done, failed, display: Mutex::new(display), started: Instant::now() }
    }

    /// Begins with `done` rows from earlier runs, of which `failed` are not done; they do not count in the rate.
    pub fn resumed(self, done: u64, failed: u64) -> Self {
        Self { before: done, done: AtomicU64::new(done), failed: AtomicU64::new(failed), ..self }
    }

    /// Writes the last line, or leaves the bar as it is and goes to the next line.
    pub fn finish(&self) {
        self.show(Occasion::End);
    }

    /// Counts a row that ended.
    pub fn row_ended(&self, status: RowStatus) {
        if status != RowStatus::Done {
            self.failed.fetch_add(1, Ordering::Relaxed);
        }
        self.done.fetch_add(1, Ordering::Relaxed);
    }

    /// Shows the rows that ended and that time passed.
    pub fn tick(&self) {
        self.show(Occasion::Tick);
    }

    /// Writes a line at once, above the bar if there is one.
    pub fn show_now(&self) {
        self.show(Occasion::Request);
    }

    fn show(&self, occasion: Occasion) {
        let at_end = occasion == Occasion::End;
        let elapsed = self.started.elapsed();
        let [done, failed] = [&self.done, &self.failed].map(|count| count.load(Ordering::Relaxed));
        let tally = Tally { rows: self.rows, before: self.before, done, failed };
        let text = Text { tally, elapsed, at_end };
        let mut display = self.display.lock().unwrap_or_else(PoisonError::into_inner);
        match &mut *display {
            Display::Bar { bar, columns } => {
                bar.set_position(tally.done);
                bar.set_message(text.fitting(*columns));
                match occasion {
                    Occasion::Tick => {}
                    Occasion::Request => bar.println(text.to_string()),
                    Occasion::End => bar.abandon(),
                }
            }
            Display::Lines { sink, interval, last } => {
                if occasion != Occasion::Tick || elapsed.saturating_sub(*last) >= *interval {
                    *last = elapsed;
                    // A log that cannot be written must not end a sweep whose results can.
                    let _ = writeln!(sink, "{text}").and_then(|()| sink.flush());
                }
            }
        }
    }
}

/// Reason for printing the progress.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Occasion {
    Tick,
    Request,
    End,
}

#[derive(Debug, Clone, Copy)]
struct Tally {
    rows: u64,
    /// Rows done before this run.
    before: u64,
    done: u64,
    failed: u64,
}

/// `120 of 500 rows, 2 failed, 14.2 rows/s, 00:00:27 left`; at the end `..., 00:00:35 in all (51,000 rows an hour, 410,000 in a night
/// of 8 h)`, at the rate of this run.
struct Text {
    tally: Tally,
    elapsed: Duration,
    at_end: bool,
}

impl Text {
    /// Rows per second; `None` before the first has ended.
    fn rate(&self) -> Option<f64> {
        let (new, seconds) = (self.tally.done - self.tally.before, self.elapsed.as_secs_f64());
        (new > 0 && seconds > 0.0).then(|| new as f64 / seconds)
    }

    /// Time left; at the end the time that it took.
    fn clock(&self) -> Option<String> {
        if self.at_end {
            return Some(clock(self.elapsed.as_secs_f64()));
        }
        let left = self.tally.rows.saturating_sub(self.tally.done) as f64;
        self.rate().map(|rate| clock(left / rate))
    }

    /// The longest text that fits: with the forecast, without it, or the figures alone.
    fn fitting(&self, columns: usize) -> String {
        let whole = self.to_string();
        let brief = whole.split(" (").next().unwrap_or_default().to_owned();
        let texts = [whole, brief].into_iter();
        texts.into_iter().find(|text| text.chars().count() <= columns).unwrap_or_else(|| self.short())
    }

    /// The figures alone: `120/500 00:00:27, 2 failed`.
    fn short(&self) -> String {
        let Tally { rows, done, failed, .. } = self.tally;
        let clock = self.clock().map_or(String::new(), |clock| format!(" {clock}"));
        let failed = if failed == 0 { String::new() } else { format!(", {failed} failed") };
        format!("{done}/{rows}{clock}{failed}")
    }
}

impl fmt::Display for Text {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Tally { rows, done, failed, .. } = self.tally;
        write!(f, "{done} of {rows} rows, {failed} failed")?;
        if let Some(rate) = self.rate() {
            write!(f, ", {} rows/s", three_digits(rate))?;
        }
        if let Some(clock) = self.clock() {
            write!(f, ", {clock} {}", if self.at_end { "in all" } else { "left" })?;
        }
        match self.rate().filter(|_| self.at_end) {
            Some(rate) => {
                let hour = 3600.0 * rate;
                write!(
                    f,
                    " ({} rows an hour, {} in a night of {NIGHT_HOURS} h)",
                    two_digits(hour),
                    two_digits(NIGHT_HOURS * hour)
                )
            }
            None => Ok(()),
        }
    }
}

/// A positive number to two digits, its thousands set apart: what a forecast is good for.
fn two_digits(value: f64) -> String {
    let unit = 10_f64.powi(value.max(1.0).log10() as i32 - 1).max(1.0);
    let digits = format!("{:.0}", (value / unit).round() * unit);
    let apart = digits.len() % 3;
    let (head, tail) = digits.split_at(apart);
    let groups = (!head.is_empty()).then_some(head).into_iter().map(str::to_owned);
    let tail = tail.as_bytes().chunks(3).map(|group| String::from_utf8_lossy(group).into_owned());
    groups.chain(tail).collect::<Vec<_>>().join(",")
}

/// A positive number to about three digits, without exponent.
fn three_digits(value: f64) -> String {
    let decimals = match value {
        v if v >= 100.0 => 0,
        v if v >= 10.0 => 1,
        v if v >= 1.0 => 2,
        _ => 4,
    };
    format!("{value:.decimals$}")
}

/// Seconds as `hh:mm:ss`, rounded.
pub(super) fn clock(seconds: f64) -> String {
    let seconds = seconds.round() as u64;
    format!("{:02}:{:02}:{:02}", seconds / 3600, seconds / 60 % 60, seconds % 60)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use indicatif::TermLike;

    use super::*;

    #[derive(Clone, Default)]
    struct Log(Arc<Mutex<Vec<u8>>>);

    impl Log {
        fn text(&self) -> String {
            String::from_utf8(self.0.lock().expect("not poisoned").clone()).expect("UTF-8")
        }
    }

    impl Write for Log {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.0.lock().expect("not poisoned").extend_from_slice(bytes);
            Ok(bytes.len())
        }
        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn text_has_rate_and_time_left() {
        let tally = Tally { rows: 500, before: 0, done: 120, failed: 2 };
        let mut text = Text { tally, elapsed: Duration::from_secs(8), at_end: false };
        assert_eq!(text.to_string(), "120 of 500 rows, 2 failed, 15.0 rows/s, 00:00:25 left");
        text.at_end = true;
        let end = "15.0 rows/s, 00:00:08 in all (54,000 rows an hour, 430,000 in a night of 8 h)";
        assert_eq!(text.to_string(), format!("120 of 500 rows, 2 failed, {end}"));
        text.tally.before = 40;
        let end = "10.0 rows/s, 00:00:08 in all (36,000 rows an hour, 290,000 in a night of 8 h)";
        assert_eq!(text.to_string(), format!("120 of 500 rows, 2 failed, {end}"));
        text.tally.before = 0;
        text.tally.done = 0;
        text.at_end = false;
        assert_eq!(text.to_string(), "0 of 500 rows, 2 failed");
    }

    #[test]
    fn times_over_a_day_stay_readable() {
        assert_eq!(clock(90_061.4), "25:01:01");
        assert_eq!(three_digits(0.01234), "0.0123");
        let numbers = [0.4, 7.2, 83.6, 999.6, 12_345.0, 1_549_999.0].map(two_digits);
        assert_eq!(numbers, ["0", "7", "84", "1,000", "12,000", "1,500,000"]);
    }

    #[test]
    fn lines_are_rare_and_plain() {
        let log = Log::default();
        let progress = Progress::lines(1000, Duration::from_secs(3600), Box::new(log.clone()));
        for row in 0..1000 {
            let failed = row % 100 == 0;
            progress.row_ended(if failed { RowStatus::Diverged } else { RowStatus::Done });
            progress.tick();
        }
        assert_eq!(log.text(), "", "the interval is not over");
        progress.finish();
        let text = log.text();
        assert!(text.starts_with("1000 of 1000 rows, 10 failed, "), "{text}");
        assert_eq!(text.lines().count(), 1);
        assert!(text.chars().all(|c| c == '\n' || !c.is_control()), "{text:?}");
    }

    #[test]
    fn lines_come_without_rows_ending() {
        let log = Log::default();
        let progress = Progress::lines(10, Duration::ZERO, Box::new(log.clone()));
        progress.tick();
        assert_eq!(log.text(), "0 of 10 rows, 0 failed\n");
    }

    #[test]
    fn a_broken_log_is_no_error() {
        struct Broken;
        impl Write for Broken {
            fn write(&mut self, _: &[u8]) -> io::Result<usize> {
                Err(io::Error::other("closed"))
            }
            fn flush(&mut self) -> io::Result<()> {
                Err(io::Error::other("closed"))
            }
        }
        let progress = Progress::lines(1, Duration::ZERO, Box::new(Broken));
        progress.row_ended(RowStatus::Done);
        progress.finish();
    }

    /// A terminal that keeps what is written.
    #[derive(Clone)]
    struct Screen(Log, u16);

    impl fmt::Debug for Screen {
        fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("Screen")
        }
    }

    impl TermLike for Screen {
        fn width(&self) -> u16 {
            self.1
        }
        fn move_cursor_up(&self, _: usize) -> io::Result<()> {
            Ok(())
        }
        fn move_cursor_down(&self, _: usize) -> io::Result<()> {
            Ok(())
        }
        fn move_cursor_right(&self, _: usize) -> io::Result<()> {
            Ok(())
        }
        fn move_cursor_left(&self, _: usize) -> io::Result<()> {
            Ok(())
        }
        fn write_line(&self, text: &str) -> io::Result<()> {
            writeln!(self.0.clone(), "{text}")
        }
        fn write_str(&self, text: &str) -> io::Result<()> {
            // What is written at once is a line.
            self.write_line(text)
        }
        fn clear_line(&self) -> io::Result<()> {
            Ok(())
        }
        fn flush(&self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_narrow_terminal_gets_the_figures_in_a_line() {
        let screen = Screen(Log::default(), 20);
        let progress = Progress::bar(1000, ProgressDrawTarget::term_like(Box::new(screen.clone())), 20);
        for row in 0..1000 {
            progress.row_ended(if row % 100 == 0 { RowStatus::Invalid } else { RowStatus::Done });
        }
        progress.finish();
        let text = screen.0.text();
        assert!(text.contains("1000/1000 00:00:0"), "{text:?}");
        assert!(text.lines().all(|line| line.chars().count() <= 20), "{text:?}");
        let tally = Tally { rows: 500, before: 0, done: 120, failed: 2 };
        let text = Text { tally, elapsed: Duration::from_secs(8), at_end: false };
        assert_eq!(text.short(), "120/500 00:00:25, 2 failed");
        let whole = "120 of 500 rows, 2 failed, 15.0 rows/s, 00:00:25 left";
        assert_eq!([60, 53, 52].map(|columns| text.fitting(columns)), [whole, whole, "120/500 00:00:25, 2 failed"]);
        let end = Text { at_end: true, ..text };
        assert_eq!(end.fitting(62), "120 of 500 rows, 2 failed, 15.0 rows/s, 00:00:08 in all");
    }

    #[test]
    fn the_bar_shows_the_text() {
        let screen = Screen(Log::default(), 100);
        let progress = Progress::bar(2, ProgressDrawTarget::term_like(Box::new(screen.clone())), 100);
        progress.row_ended(RowStatus::Done);
        progress.row_ended(RowStatus::Invalid);
        progress.finish();
        let text = screen.0.text();
        assert!(text.contains("100 %  2 of 2 rows, 1 failed"), "{text:?}");
    }
}
