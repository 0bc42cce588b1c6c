//! Measurement of computing time.

use std::time::Duration;

/// True if the system reports the CPU time of a thread; otherwise [`thread_time`] returns the
/// elapsed time.
const TOLD: bool = cfg!(unix);

/// The name of the time that [`thread_time`] measures, for labels.
pub const THREAD_TIME: &str = if TOLD { "CPU time" } else { "wall time" };

/// Heading of a column of times that [`thread_time`] measures.
pub const THREAD_TIME_S: &str = if TOLD { "CPU time, s" } else { "wall time, s" };

/// Returns the CPU time of the calling thread since an arbitrary instant. Other threads and
/// processes do not contribute. If the system does not report CPU times, returns the elapsed time.
pub fn thread_time() -> Duration {
    #[cfg(unix)]
    {
        let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
        Duration::new(time.tv_sec.max(0) as u64, time.tv_nsec.clamp(0, 999_999_999) as u32)
    }
    #[cfg(not(unix))]
    {
        use std::sync::OnceLock;
        use std::time::Instant;
        static BEGAN: OnceLock<Instant> = OnceLock::new();
        BEGAN.get_or_init(Instant::now).elapsed()
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::time::Instant;

    #[test]
    fn sleep_takes_no_time_and_work_does() {
        let (began, wall) = (thread_time(), Instant::now());
        std::thread::sleep(Duration::from_millis(60));
        assert!(thread_time() - began < Duration::from_millis(30));
        let mut sum = 0.0_f64;
        while thread_time() - began < Duration::from_millis(20) {
            sum += std::hint::black_box(sum).sin();
        }
        assert!(wall.elapsed() >= Duration::from_millis(80));
    }
}
