//! Lights pictures on a backend: by a plan, or with all lights.

use std::time::{Duration, Instant};

use landfall_accuracy::bench::clock::Start;
use landfall_exec::backend::Backend;
use landfall_interp::{Cpu, Settings};
use landfall_layout::Error;
use landfall_light::culling::{LightSet, Plan};
use landfall_light::render::tally::Tally;
use landfall_light::render::{Rendered, Renderer};

use super::clock::timed;
use super::{PreparedScene, RenderStop};
use crate::args::{BackendName, RenderArgs};
use crate::backends;
use crate::output::Streams;

pub struct BackendPicture {
    pub rendered: Rendered,
    pub tally: Option<Tally>,
    /// The time that passed.
    pub elapsed: Duration,
    /// The time that it took the processor, and a driver.
    pub took: Duration,
}

enum PictureBackend {
    Cpu(Box<Cpu>),
    Driver(Box<dyn Backend>),
}

pub struct Lighting<'a> {
    name: BackendName,
    streams: &'a Streams,
    opened: PictureBackend,
}

impl<'a> Lighting<'a> {
    pub fn open(
        name: BackendName,
        args: &RenderArgs,
        made: &PreparedScene<'_>,
        streams: &'a Streams,
    ) -> Result<Lighting<'a>, RenderStop> {
        let opened = match name {
            BackendName::Cpu => {
                let settings = Settings { watch: args.watch, ..Settings::default() };
                PictureBackend::Cpu(Box::new(made.whole().cpu(settings)))
            }
            BackendName::Gl | BackendName::Gpu => {
                let opened = backends::open_one(name, args.adapter.as_deref());
                PictureBackend::Driver(opened.map_err(|failure| {
                    Error::new(name.name(), format!("cannot render: {}", failure.message))
                        .with_help("`landfall devices` lists the backends; cpu needs no driver")
                })?)
            }
        };
        Ok(Lighting { name, streams, opened })
    }

    pub fn backend(&mut self) -> &mut dyn Backend {
        match &mut self.opened {
            PictureBackend::Cpu(cpu) => cpu.as_mut(),
            PictureBackend::Driver(driver) => driver.as_mut(),
        }
    }

    pub fn light_all(&mut self, made: &PreparedScene<'_>) -> Result<BackendPicture, RenderStop> {
        let all = LightSet::all(&made.upload.lights);
        // All lights at each fragment: the plan that every other one is compared with.
        let plan = Plan::all_lights(made.frame.fragments.len(), all);
        self.by_plan(made, made.whole(), &plan)
    }

    /// Lights the picture by a plan, which `renderer` executes.
    pub fn by_plan(
        &mut self,
        made: &PreparedScene<'_>,
        renderer: &Renderer,
        plan: &Plan,
    ) -> Result<BackendPicture, RenderStop> {
        let (work, begun) = (made.work(), Instant::now());
        let mut progress = Progress::new(self.name, made, self.streams);
        let mut tally = None;
        let (rendered, took) = match &mut self.opened {
            PictureBackend::Cpu(cpu) => {
                // The interpreter counts what it met, such as undefined values; drivers cannot.
                let mut counts = Tally::default();
                let start = Start::now();
                let rendered = renderer.render_plan(cpu.as_mut(), &work, plan, &mut |cpu, n| {
                    counts.add(&cpu.notes);
                    progress.add(n);
                })?;
                tally = Some(counts);
                (rendered, start.elapsed().time)
            }
            PictureBackend::Driver(driver) => timed(driver.as_mut(), &mut |driver| {
                renderer.render_plan(driver, &work, plan, &mut |_, n| progress.add(n))
            })?,
        };
        Ok(BackendPicture { rendered, tally, elapsed: begun.elapsed(), took })
    }
}

/// Prints how much of a picture is lit.
struct Progress<'a> {
    name: BackendName,
    done: usize,
    total: usize,
    /// `None` if nothing is to be printed.
    streams: Option<&'a Streams>,
}

impl<'a> Progress<'a> {
    fn new(name: BackendName, made: &PreparedScene<'_>, streams: &'a Streams) -> Progress<'a> {
        // At least 1, so that an empty picture divides by no zero.
        let total = made.frame.fragments.len().max(1);
        let streams = Some(streams).filter(|streams| streams.shows_progress_first());
        Progress { name, done: 0, total, streams }
    }

    fn add(&mut self, count: usize) {
        self.done += count;
        if let Some(streams) = self.streams {
            let Progress { name, done, total, .. } = self;
            let (name, part) = (name.name(), *done * 100 / *total);
            streams.progress(&format!("{name}: {done} of {total} fragments, {part} %"));
        }
    }
}
