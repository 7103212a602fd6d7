//! Runs jobs beside Python: without its lock, with Ctrl-C heard.

use crate::baked::Baked;
use crate::error::error;
use crate::probes::Probes;
use crate::{options, scene};
use ambake::{Progress, Resume, Scene};
use pyo3::exceptions::{PyFileNotFoundError, PyRuntimeError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

/// Between two looks at Python's signals and the counters.
const TICK: Duration = Duration::from_millis(50);

/// Bakes meshes in memory; into the folder `output` too, where one is given.
#[pyfunction]
pub fn bake_meshes(
    py: Python<'_>,
    meshes: Vec<scene::Given<'_>>,
    options: &Bound<'_, PyDict>,
    output: Option<PathBuf>,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<Baked> {
    let scene = scene::of(meshes)?;
    bake(py, scene, options, output.as_deref(), progress)
}

/// Bakes the scene in an OBJ, glTF or GLB file, likewise.
#[pyfunction]
pub fn bake_file(
    py: Python<'_>,
    path: PathBuf,
    options: &Bound<'_, PyDict>,
    output: Option<PathBuf>,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<Baked> {
    let scene = file(py, &path)?;
    bake(py, scene, options, output.as_deref(), progress)
}

/// The scene in a file.
fn file(py: Python<'_>, path: &Path) -> PyResult<Scene> {
    if !path.is_file() {
        let problem = format!("there is no scene file {}", path.display());
        return Err(PyFileNotFoundError::new_err(problem));
    }
    py.detach(|| ambake::load(path)).map_err(error)
}

/// What is told from the bake's threads to Python's.
#[derive(Default)]
struct Meter {
    done: AtomicU64,
    total: AtomicU64,
    cancelled: AtomicBool,
}

impl Progress for Meter {
    fn advance(&self, done: u64, total: u64) {
        self.done.fetch_max(done, Ordering::Relaxed);
        self.total.store(total, Ordering::Relaxed);
    }

    fn cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }
}

fn bake(
    py: Python<'_>,
    scene: Scene,
    given: &Bound<'_, PyDict>,
    output: Option<&Path>,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<Baked> {
    let bake = options::bake(&scene, given)?;
    let job = |meter: &Meter| match output {
        None => bake.run(meter),
        Some(folder) => {
            let job = bake.prepare_with(meter)?;
            Ok(job.run_into_kept(folder, Resume::IfFound, meter)?.0)
        }
    };
    Ok(Baked(beside(py, progress, job)?))
}

/// The light of places in the scene of a file.
#[pyfunction]
pub fn probes_file(
    py: Python<'_>,
    path: PathBuf,
    options: &Bound<'_, PyDict>,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<Probes> {
    let scene = file(py, &path)?;
    let (places, options, threads) = options::probes(&scene, options)?;
    let gather = |meter: &Meter| {
        let pool = ambake::rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()?;
        pool.install(|| ambake::Probes::gather(&scene, &places, &options, meter))
    };
    Ok(Probes::new(beside(py, progress, gather)?))
}

/// Runs a job on a thread of its own, while Python's signals are heard.
fn beside<T: Send>(
    py: Python<'_>,
    progress: Option<Bound<'_, PyAny>>,
    job: impl FnOnce(&Meter) -> Result<T, ambake::Error> + Send,
) -> PyResult<T> {
    let meter = Meter::default();
    let (mut interrupted, mut told) = (None, 0);
    let result = std::thread::scope(|scope| {
        let (meter, python) = (&meter, std::thread::current());
        let worker = scope.spawn(move || {
            let result = job(meter);
            python.unpark();
            result
        });
        while !worker.is_finished() {
            py.detach(|| std::thread::park_timeout(TICK));
            if interrupted.is_none()
                && let Err(error) = look(py, meter, progress.as_ref(), &mut told)
            {
                meter.cancelled.store(true, Ordering::Relaxed);
                interrupted = Some(error);
            }
        }
        worker.join().ok()
    });
    if let Some(error) = interrupted {
        return Err(error);
    }
    match result {
        Some(result) => result.map_err(error),
        None => Err(PyRuntimeError::new_err(
            "the job broke off; this is a fault of ambake, please report it",
        )),
    }
}

/// Raises a pending KeyboardInterrupt, and tells how far the bake is.
fn look(
    py: Python<'_>,
    meter: &Meter,
    progress: Option<&Bound<'_, PyAny>>,
    told: &mut u64,
) -> PyResult<()> {
    py.check_signals()?;
    let (done, total) = (&meter.done, &meter.total);
    let (done, total) = (done.load(Ordering::Relaxed), total.load(Ordering::Relaxed));
    if let Some(progress) = progress
        && done > *told
    {
        *told = done;
        progress.call1((done, total))?;
    }
    Ok(())
}
