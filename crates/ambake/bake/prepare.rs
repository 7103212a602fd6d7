//! From the options of a bake to its job.

use super::Bake;
use crate::baked::Baked;
use crate::error::Error;
use crate::job::{Given, Job};
use crate::layout::Layout;
use crate::options::Options;
use crate::options::check::check_lamps;
use crate::scene::Scene;
use ::bake::Bounces;
use layers::Progress;

impl Bake {
    /// Lays the texels out, and nothing more.
    ///
    /// # Errors
    /// As [`Bake::prepare`].
    pub fn lay_out(&self) -> Result<Layout, Error> {
        if self.update.is_some() {
            let problem = "gives a layout that holds for its folder alone; lay out without it";
            return Err(Error::option("update", problem));
        }
        let job = self.prepare()?;
        Ok(Layout::new(job.scene(), job.options(), job.atlas().clone()))
    }

    /// Plans the bake, lays its texels out and builds the ray scene.
    ///
    /// # Errors
    /// An option is out of its range or excludes another, the charts do not fit, or a backend refuses the scene.
    pub fn prepare(&self) -> Result<Job, Error> {
        self.prepare_with(&())
    }

    /// As [`Bake::prepare`], for a listener, which hears of phases and may cancel: after each of them, and while texels
    /// are laid out.
    ///
    /// # Errors
    /// As [`Bake::prepare`]; [`Error::Cancelled`].
    pub fn prepare_with(&self, progress: &dyn Progress) -> Result<Job, Error> {
        let (scene, options) = self.settled()?;
        Job::prepare(scene, options, self.given(), progress)
    }

    /// As [`Bake::prepare`], on the layout and the ray scene of an earlier job of the same scene: nothing is laid out
    /// or built again. What it bakes is the same, bit for bit, as without that job. Sky, lights, rays, bounces, layers,
    /// albedo and all else that decides light alone may differ.
    ///
    /// ```
    /// # fn main() -> Result<(), ambake::Error> {
    /// # let scene = ambake::load(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/wall_long.obj"))?;
    /// use ambake::Bake;
    /// let bake = Bake::new(&scene).size(64).rays(16);
    /// let day = bake.prepare()?;
    /// let night = bake.clone().sky([0.01, 0.02, 0.05]).prepare_on(&day)?;
    /// let (day, night) = (day.run(&())?, night.run(&())?);
    /// # assert_eq!(day.page(0).layer(ambake::Layer::Diffuse), night.page(0).layer(ambake::Layer::Diffuse));
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// An option is out of its range or excludes another; the scene, the backend or an option on which layout or ray
    /// scene depend is not that of the earlier job, and the message names it. Of lights and of an eye point these
    /// depend on which closed surfaces they stand in.
    pub fn prepare_on(&self, job: &Job) -> Result<Job, Error> {
        let (scene, options) = self.settled()?;
        job.prepare_again(&scene, options, self.given())
    }

    /// The scene and the options with all that follows from both.
    fn settled(&self) -> Result<(Scene, Options), Error> {
        let mut options = self.options.clone().settled(&self.scene);
        options.check()?;
        if options.bounces != Bounces::Off {
            check_lamps(&self.scene)?;
        }
        options.complete();
        let scene = options.cast(&self.scene)?;
        Ok((scene, options))
    }

    fn given(&self) -> Given<'_> {
        Given {
            made: &self.made,
            threads: self.threads,
            limit: self.limit,
            layout: self.layout.as_ref(),
            layout_file: self.layout_file.as_deref(),
            update: self.update.as_deref(),
            verify: self.verify,
        }
    }

    /// Bakes every page and keeps the result in memory.
    ///
    /// # Errors
    /// As [`Bake::prepare`]; [`Error::Cancelled`] where the listener cancels.
    pub fn run(&self, progress: &dyn Progress) -> Result<Baked, Error> {
        self.prepare_with(progress)?.run(progress)
    }
}
