//! Input files of the commands that only look at meshes (`inspect`, `check`), and their batch run: a text for one file, a table for
//! several.

use std::path::PathBuf;

use clap::Args;
use isomend::io::Loaded;
use isomend::job::{Batch, BatchObserver, BatchResult, JobError, JobSpec, Looked, Work};
use isomend::{Control, Unit};

use super::console::{self, Console};
use super::input;
use super::json::{self, Target};
use super::report::ReportArgs;
use super::table::table;
use super::{CommonArgs, End};
use isomend_files::job::contradiction;

/// Options for the files to look at.
#[derive(Debug, Args)]
pub struct LookArgs {
    /// The mesh: OBJ, PLY, STL, glTF, GLB, VTK legacy, VTP, OFF, 3MF or USD; `-` is standard input. For several meshes a table is printed.
    #[arg(value_name = "IN", required = true)]
    inputs: Vec<PathBuf>,

    /// The unit of the mesh's coordinates: mm, cm, m, in, um or ft. It is printed with lengths, also in --json and --report.
    #[arg(long, value_name = "UNIT")]
    pub unit: Option<Unit>,

    #[command(flatten)]
    report: ReportArgs,
}

/// What is printed of a file.
#[derive(Default)]
pub struct Shown {
    /// The text, if it is the only file.
    pub text: String,
    /// The cells of its row in a table of several files, without its name.
    pub cells: Vec<String>,
}

/// How a command looks at each of its files.
pub struct Look<'a> {
    /// The work, which only looks.
    pub work: Work,
    /// The options that all commands have.
    pub common: &'a CommonArgs,
    /// The headings of the table, without the first column, the names.
    pub headings: &'a [&'a str],
    /// Whether anything is printed.
    pub prints: bool,
    /// What is printed of a file.
    pub show: &'a dyn Fn(&JobSpec, &Looked) -> Shown,
}

impl LookArgs {
    /// Looks at each file, one after another, and prints what was found. If one of several files fails, the others are still looked at.
    ///
    /// # Errors
    /// If the files cannot be used; for a single file, also its error.
    pub fn each(&self, look: &Look, console: &Console) -> anyhow::Result<End> {
        let json = look.common.json.as_ref();
        let named = |path: &PathBuf| input::named(path, look.common.from);
        let mut batch = Batch::new(self.inputs.iter().map(named), look.work.clone());
        batch.document = json.map(Target::place);
        batch.drawings = self.report.drawings(json)?;
        batch.deliverables.unit = self.unit;
        // Report errors before waiting for standard input.
        batch.check().map_err(super::cli_error)?;
        batch.sources.iter_mut().try_for_each(input::fetch)?;
        let mut printer = Printer {
            console,
            look,
            unit: self.unit,
            single: self.inputs.len() == 1,
            text: String::new(),
            rows: Vec::new(),
        };
        let ended = batch.run(&mut printer, &Control::new());
        let ended = ended.map_err(super::cli_error)?;
        if let Some(text) = &ended.document {
            json::print(text)?;
        }
        // Nothing else is printed where the JSON document goes to standard output.
        if look.prints && !json.is_some_and(Target::is_stdout) {
            console::print_out(&printer.said())?;
        }
        Ok(End::of(&ended))
    }
}

impl End {
    /// How a command on several files ended.
    pub fn of(ended: &BatchResult) -> Self {
        match ended {
            BatchResult { failed: 1.., .. } => Self::Failed,
            BatchResult { in_part: 1.., .. } => Self::InPart,
            _ => Self::Done,
        }
    }
}

/// Collects what a batch has found.
struct Printer<'a> {
    console: &'a Console,
    look: &'a Look<'a>,
    unit: Option<Unit>,
    single: bool,
    /// The text of the only file.
    text: String,
    /// The rows of several files.
    rows: Vec<Vec<String>>,
}

impl Printer<'_> {
    /// The text of the only file, or the table.
    fn said(self) -> String {
        if self.single {
            return self.text;
        }
        let headings = ["file"].iter().chain(self.look.headings);
        let headings: Vec<String> = headings.map(ToString::to_string).collect();
        table(&headings, &self.rows, console::width())
    }
}

impl BatchObserver for Printer<'_> {
    fn has_read(&mut self, job: &JobSpec, loaded: &Loaded) {
        input::print_notes(&job.source.place, loaded, self.console);
        if let Some(note) = contradiction(loaded.attributes.unit, self.unit) {
            let name = job.source.place.name();
            self.console.note(&format!("{name}: {note}"));
        }
    }

    fn looked(&mut self, job: &JobSpec, looked: &Looked) -> std::io::Result<()> {
        let Shown { text, cells } = (self.look.show)(job, looked);
        self.text = text;
        self.rows
            .push([vec![job.source.place.name()], cells].concat());
        Ok(())
    }

    fn failed(&mut self, job: &JobSpec, words: &str) {
        let name = job.source.place.name();
        self.console
            .failed(&input::with_name(&job.source.place, words));
        self.rows.push(vec![name, "failed".to_owned()]);
    }

    fn words(&self, error: JobError) -> String {
        format!("{:#}", super::cli_error(error))
    }
}
