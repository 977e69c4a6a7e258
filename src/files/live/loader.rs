//! What the files of a world say, read once, and the tasks that are loaded with it.

use std::path::Path;

use super::use_source;
use crate::describe::Described;
use crate::document::SourceSpan;
use crate::fault::{Fault, Faults, FilesError};
use crate::files::{Files, KnownFiles};
use crate::format::{Format, TaskFile};
use crate::lint::{self, Part};
use crate::names::Register;
use crate::parameter::refuse_open_defaults;
use crate::scene::{self, Scene};
use crate::settings::{Given, Setting};
use crate::sources::{Kept, Recorder, Sources};
use crate::task::{self, MAX_SUBMITTED, ROOT, Surroundings, Written, no_subtree};
use crate::whole::{self, Overrides, ReadWorld, name_or_that_of};
use crate::world::Built;
use ambidex_model::{Fragment, Location, MissionSpec, Names, Source, SourceKind, WorldState};

/// A task for a robot that works.
#[derive(Debug, Clone)]
pub struct LoadedTask {
    /// What is to be done.
    pub fragment: Fragment,
    /// What is legal in the files but surely not meant.
    pub warnings: Vec<Fault>,
    /// The files that it was made of.
    pub source: Source,
}

/// What the files of a world say, ready for any number of tasks. What a task costs does not depend on those before it.
pub struct TaskLoader {
    known: KnownFiles,
    /// As the files say it; objects and channels as they have become.
    scene: Scene,
    tolerance_m: f64,
}

/// A task file on its way.
struct Reading<'a> {
    path: &'a Path,
    settings: &'a [Setting],
    part: Part,
    base: &'a MissionSpec,
    now: &'a WorldState,
}

impl TaskLoader {
    /// Reads what the files of a world say; any world that comes of it by objects and tasks that come and go will do.
    ///
    /// # Errors
    /// Every mistake in the files; that there are none.
    pub fn new(base: &MissionSpec) -> Result<Self, FilesError> {
        let mut faults = Faults::default();
        let Some(source) = &base.source else {
            let file = faults.open(&base.name, String::new());
            let span = SourceSpan { file, ..SourceSpan::default() };
            faults.push((span, ""), "the world was not made of files, so that nobody knows what tasks can use");
            return faults.into_result(None).map(|(loader, _)| loader);
        };
        let kept = Kept::new(source);
        let path = Path::new(&source.mission);
        let files = Files::with_includes(&kept, path, &mut faults);
        let overrides = Overrides { robot: source.robot.as_deref().map(Path::new), settings: &[] };
        let read = whole::read_world(path, &files, &overrides, &mut faults);
        let known = files.into_known(&faults);
        let loader = read.and_then(|(ReadWorld { scene, .. }, _)| {
            let tolerance_m = scene.world.as_ref()?.tolerance_m;
            Some(Self { known, scene, tolerance_m })
        });
        faults.into_result(loader).map(|(loader, _)| loader)
    }

    /// Loads a task file for the world of `base` as it is `now`.
    ///
    /// # Errors
    /// Every mistake in its files, and every name that the world does not have.
    pub fn load_task(
        &mut self,
        sources: &dyn Sources,
        path: &Path,
        settings: &[Setting],
        base: &MissionSpec,
        now: &WorldState,
    ) -> Result<LoadedTask, FilesError> {
        self.load_file(sources, SourceKind::Task, &Reading { path, settings, part: Part::Task, base, now })
    }

    /// Loads a task file as a part of a task that is there.
    ///
    /// # Errors
    /// Like those of [`Self::load_task`].
    pub fn load_branch(
        &mut self,
        sources: &dyn Sources,
        path: &Path,
        settings: &[Setting],
        base: &MissionSpec,
        now: &WorldState,
    ) -> Result<LoadedTask, FilesError> {
        self.load_file(sources, SourceKind::Branch, &Reading { path, settings, part: Part::Branch, base, now })
    }

    /// Loads a task, a part of one or a use from what it was made of.
    ///
    /// # Errors
    /// Like those of [`Self::load_task`].
    pub fn load_source(
        &mut self,
        source: &Source,
        base: &MissionSpec,
        now: &WorldState,
    ) -> Result<LoadedTask, FilesError> {
        let settings = Setting::all_of(source);
        let part = match source.kind {
            SourceKind::Use => return self.load_use(&source.mission, &settings, base, now),
            SourceKind::Branch => Part::Branch,
            SourceKind::Task | SourceKind::Mission | SourceKind::World => Part::Task,
        };
        let path = Path::new(&source.mission);
        let reading = Reading { path, settings: &settings, part, base, now };
        let (fragment, warnings) = self.load(&Kept::new(source), &reading)?;
        Ok(LoadedTask { fragment, warnings, source: source.clone() })
    }

    /// Loads a subtree that the world's files declare.
    ///
    /// # Errors
    /// Like those of [`Self::load_task`].
    pub fn load_use(
        &mut self,
        name: &str,
        settings: &[Setting],
        base: &MissionSpec,
        now: &WorldState,
    ) -> Result<LoadedTask, FilesError> {
        self.follow(base);
        let mut faults = Faults::after(&self.known.opened);
        let world = self.world_now(base, now);
        let fragment = self.used(name, settings, &world, &mut faults);
        let (fragment, warnings) = faults.into_result(fragment)?;
        Ok(LoadedTask { fragment, warnings, source: use_source(name, settings) })
    }

    fn load_file(
        &mut self,
        sources: &dyn Sources,
        kind: SourceKind,
        reading: &Reading<'_>,
    ) -> Result<LoadedTask, FilesError> {
        let recorder = Recorder::new(sources);
        let (fragment, warnings) = self.load(&recorder, reading)?;
        Ok(LoadedTask { fragment, warnings, source: recorder.source(kind, reading.path, None, reading.settings) })
    }

    fn load(&mut self, sources: &dyn Sources, reading: &Reading<'_>) -> Result<(Fragment, Vec<Fault>), FilesError> {
        self.follow(reading.base);
        let mut faults = Faults::after(&self.known.opened);
        let files = Files::beside_known(&self.known, sources, reading.path, &mut faults);
        let fragment = self.read(&files, reading, &mut faults);
        faults.into_result(fragment)
    }

    fn read(&self, files: &Files<'_>, reading: &Reading<'_>, faults: &mut Faults) -> Option<Fragment> {
        let main = files.main().filter(|main| Format::Task.is_that_of(*main, faults))?;
        let file = TaskFile::take(main, faults)?;
        let known_files = self.known.opened.len();
        let (mut kinds, mut subtrees) = (self.scene.kinds.beside(known_files), self.scene.subtrees.beside(known_files));
        let own = (file.declared.behaviors, file.declared.subtrees);
        scene::declare(files, own, (&mut kinds, &mut subtrees), faults);
        let world = self.world_now(reading.base, reading.now);
        let around = Surroundings { kinds: &kinds, ..self.around(&world) };
        task::check_all(&mut subtrees, &around, faults);
        kinds.check_tables(&around.known, files.main_file(), faults);
        subtrees.check_defaults(&around.known, files.main_file(), faults);
        let parameters = file.declared.parameters;
        refuse_open_defaults("a task", parameters.iter(), faults);
        let given = Given::of("the task", parameters, reading.settings, &around.known, faults);
        let name = name_or_that_of(file.mission, reading.path);
        let written = file.task.map(|task| Written { name, task, label: None });
        let built = written.and_then(|task| task::build(task, &subtrees, &around, &given, faults));
        if let Some(unused) = file.world.filter(|_| faults.errors() > 0) {
            let help = "what it lacks is brought into the world that is there, as with `ambidex world add OBJECT`";
            faults.warn(
                &unused,
                "a task is for the world as it is: this one is not used".to_owned(),
                Some(help.into()),
            );
        }
        let built = built?;
        self.check(&built, &world, reading.part, faults);
        Some(built.fragment)
    }

    /// A subtree of the world's files with what is told for its parameters.
    fn used(&self, name: &str, settings: &[Setting], world: &Built, faults: &mut Faults) -> Option<Fragment> {
        let subtrees = &self.scene.subtrees;
        let Some(part) = subtrees.get(name) else {
            let written = format!("use: {name}");
            let file = faults.open(&written, String::new());
            let span = SourceSpan { file, ..SourceSpan::default() };
            faults.push_with((span, &written), no_subtree(name), || subtrees.suggestion(name));
            return None;
        };
        let around = self.around(world);
        let given = Given::of(&format!("`{name}`"), part.parameters.clone(), settings, &around.known, faults);
        let told = |parameter: &str| settings.iter().find(|setting| setting.name == parameter);
        let first = part.parameters.iter().find_map(|parameter| told(&parameter.name.value));
        let label = part.label(first.map(|setting| setting.value.clone()));
        let written = Written { name: label.value.clone(), task: part.task(), label: Some(label) };
        let built = task::build(written, subtrees, &around, &given, faults)?;
        self.check(&built, world, Part::Task, faults);
        Some(built.fragment)
    }

    /// What a task sees, in the world as it is.
    fn around<'a>(&'a self, world: &'a Built) -> Surroundings<'a> {
        Surroundings { world: Some(world), most_nodes: MAX_SUBMITTED, ..self.scene.around() }
    }

    /// What is legal in a task but surely not meant.
    fn check(&self, built: &task::BuiltTask, world: &Built, part: Part, faults: &mut Faults) {
        let (Some(robot), Some(names)) = (&self.scene.robot, &self.scene.names) else { return };
        let fragment = &built.fragment;
        let alone = MissionSpec {
            name: fragment.name.clone(),
            robot: robot.robot.clone(),
            world: world.spec.clone(),
            start: world.start.clone(),
            names: Names {
                nodes: [ROOT.to_owned()].into_iter().chain(fragment.names.clone()).collect(),
                places: names.places.names().to_vec(),
                stands: names.stands.clone(),
                objects: names.objects.names().to_vec(),
                facts: names.facts.names().to_vec(),
                ..robot.names.clone()
            },
            tree: fragment.clone().into_tree(),
            source: None,
        };
        lint::check(&alone, &built.spans, part, faults);
    }

    /// What has come into the world and gone out of it since the last task, and which channels are new.
    fn follow(&mut self, base: &MissionSpec) {
        if let Some(names) = &mut self.scene.names
            && names.objects.names() != base.names.objects
        {
            names.objects = Register::by_id("object", &base.names.objects);
        }
        let (channels, all) = (&mut self.scene.channels, &base.names.channels);
        // No channel ever goes, and none changes its name.
        let known = channels.names();
        if known.last() != known.len().checked_sub(1).and_then(|last| all.get(last)) {
            *channels = Register::by_id("channel", all);
        }
        let known = channels.names().len();
        all[known..].iter().for_each(|channel| channels.add(channel));
    }

    /// The world as it is.
    fn world_now(&self, base: &MissionSpec, now: &WorldState) -> Built {
        let mut start = now.clone();
        start.objects.resize(base.names.objects.len(), Location::Unknown);
        Built::of(base.world.clone(), start, self.tolerance_m)
    }
}
