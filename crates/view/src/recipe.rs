//! Recipes: a session as a list of commands that repeat it, as a shell script and as TOML for other programs.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::deliver::{add_options, add_unit};
use super::files::{path_argument, relative, template_argument};
use super::runs::Runs;
use super::state::{State, StepDone};
use super::words::{Command, NO_TEXTURE};
use isomend_files::job::Deliverables;

/// Exit code of a command that left a hole open that was to be filled.
const IN_PART: u8 = 3;

/// The commands of a session.
pub struct Recipe {
    lines: Vec<Line>,
    /// Intermediate files between two commands.
    between: Vec<String>,
    /// The masks, by the names of their files, which are beside the recipe.
    masks: BTreeMap<String, Runs>,
}

/// A command with its files, whose paths are relative to the recipe's folder.
struct Line {
    command: Command,
    input: String,
    output: String,
    /// Whether it exits with [`IN_PART`].
    in_part: bool,
}

/// Paths of the files of a recipe.
pub struct Places<'a> {
    /// The folder of the recipe.
    pub folder: &'a Path,
    /// File name of the recipe without its extension; the names of mask files begin with it.
    pub stem: &'a str,
    /// The input file, and its format if the caller set it.
    pub input: (&'a Path, Option<isomend_files::io::Format>),
    /// The intermediate file after the given number of steps.
    pub between: &'a dyn Fn(usize) -> PathBuf,
    /// The saved file.
    pub output: &'a Path,
    /// What is handed over with the saved file.
    pub deliverables: &'a Deliverables,
    /// Whether all deliverables can be made, and all patches are within the tolerance.
    pub delivers: bool,
    /// Whether patches get no texels of their own in intermediate files, as in the session. See [`App::plain_between`].
    ///
    /// [`App::plain_between`]: super::app::App::plain_between
    pub plain_between: bool,
}

impl Recipe {
    /// The commands that make a mesh and save it; as text if `ascii` is set. `last` is a further command that saves it, if the last step
    /// cannot.
    pub fn new(state: &State, last: Option<Command>, ascii: bool, places: &Places) -> Self {
        let steps = state.steps();
        let argument = |path: &Path| path_argument(&relative(places.folder, path));
        let is_between = |number: usize| number < steps.len() || last.is_some();
        let mut commands: Vec<(Command, Option<&Runs>, bool)> = (1..)
            .zip(&steps)
            .map(|(number, step)| {
                let is_plain = places.plain_between && is_between(number);
                let command = step.command_in(places.folder, is_plain);
                (command, step.mask.as_ref(), !step.complete)
            })
            .collect();
        if let Some((command, _, in_part)) = commands.last_mut() {
            add_options(command, places.deliverables, &argument);
            *in_part |= !places.delivers;
        }
        commands.extend(last.map(|mut command| {
            add_unit(&mut command, places.deliverables.unit);
            (command, None, false)
        }));
        let count = commands.len();
        let mut recipe = Self {
            lines: Vec::new(),
            between: Vec::new(),
            masks: BTreeMap::new(),
        };
        let mut input = argument(places.input.0);
        for (number, (mut command, mask, in_part)) in (1..).zip(commands) {
            if let Some(format) = places.input.1.filter(|_| number == 1) {
                command.option("from", format.extension());
            }
            if let Some(mask) = mask {
                let name = format!("{}.step{number}.faces", places.stem);
                command.option("faces", &name);
                recipe.masks.insert(name, mask.clone());
            }
            let output = match number == count {
                true => argument(places.output),
                false => argument(&(places.between)(number)),
            };
            if number < count {
                recipe.between.push(output.clone());
            } else if ascii {
                command.flag("ascii");
            }
            recipe.lines.push(Line {
                command,
                input,
                output: output.clone(),
                in_part,
            });
            input = output;
        }
        recipe
    }

    /// The mask files: their names and contents.
    pub fn masks(&self) -> impl Iterator<Item = (&str, String)> {
        self.masks
            .iter()
            .map(|(name, runs)| (name.as_str(), runs.text()))
    }

    /// The recipe as a shell script.
    pub fn shell(&self) -> String {
        let mut text = format!(
            "#!/bin/sh\n# Repeats a session of `isomend view`, version {}: the same file, to the byte.\nset -e\ncd \"$(dirname \"$0\")\"\n",
            env!("CARGO_PKG_VERSION")
        );
        if !self.between.is_empty() {
            let files: Vec<String> = self.between.iter().map(|f| quoted(f)).collect();
            let files = files.join(" ");
            // Quoted once more, since the shell parses the command of a trap again when it runs it.
            text += &format!("trap {} EXIT\n", quoted(&format!("rm -f {files}")));
        }
        for line in &self.lines {
            text += &line.shell();
            if line.in_part {
                text += &format!(" || [ $? -eq {IN_PART} ]");
            }
            text.push('\n');
        }
        text
    }

    /// The recipe as TOML: a list of steps, with options as in a file for `--config`.
    pub fn toml(&self) -> String {
        let mut text = format!(
            "# Repeats a session of `isomend view`. Options are as in a file for --config; paths are relative to this file's folder.\n\
             version = {}\nbetween = [{}]\n",
            string(env!("CARGO_PKG_VERSION")),
            listed(self.between.iter().map(String::as_str))
        );
        for line in &self.lines {
            text += &format!(
                "\n[[step]]\ncommand = {}\ninput = {}\noutput = {}\nin_part = {}\n",
                string(&line.command.name),
                string(&line.input),
                string(&line.output),
                line.in_part
            );
            text += "[step.options]\n";
            let mut options: BTreeMap<&str, Vec<Option<&str>>> = BTreeMap::new();
            for (name, value) in &line.command.options {
                options.entry(name).or_default().push(value.as_deref());
            }
            for (name, values) in options {
                let value = match &values[..] {
                    [None] => "true".to_owned(),
                    [Some(value)] => string(value),
                    values => format!("[{}]", listed(values.iter().copied().flatten())),
                };
                text += &format!("{name} = {value}\n");
            }
        }
        text
    }
}

impl StepDone {
    /// The step as a command of a recipe in a folder; its patches get no texels of their own if `is_plain` is set.
    fn command_in(&self, folder: &Path, is_plain: bool) -> Command {
        let mut command = self.command.clone();
        if let Some(file) = self.work.template() {
            command.set("like", template_argument(&relative(folder, file)));
        }
        if is_plain && self.work.makes_patches() && !self.no_texture {
            command.flag(NO_TEXTURE);
        }
        command
    }
}

impl Line {
    fn shell(&self) -> String {
        let mut words = vec!["isomend".to_owned(), self.command.name.clone()];
        words.extend([self.input.clone(), "-o".to_owned(), self.output.clone()]);
        words.extend(self.command.arguments());
        let words: Vec<String> = words.iter().map(|w| quoted(w)).collect();
        words.join(" ")
    }
}

/// Quotes a word for a shell if necessary.
pub fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./:,=+@%".contains(c);
    match !word.is_empty() && word.chars().all(plain) {
        true => word.to_owned(),
        false => format!("'{}'", word.replace('\'', "'\\''")),
    }
}

/// A TOML string. JSON's escapes are valid in TOML; in addition TOML requires an escape for DEL.
fn string(text: &str) -> String {
    serde_json::Value::from(text)
        .to_string()
        .replace('\u{7f}', "\\u007f")
}

fn listed<'a>(values: impl Iterator<Item = &'a str>) -> String {
    let values: Vec<String> = values.map(string).collect();
    values.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_quoted_where_a_shell_would_split_them() {
        assert_eq!(quoted("a/b-c.ply"), "a/b-c.ply");
        assert_eq!(quoted("my scan.ply"), "'my scan.ply'");
        assert_eq!(quoted("it's $HOME"), "'it'\\''s $HOME'");
        assert_eq!(quoted(""), "''");
        assert_eq!(path_argument(Path::new("-o.ply")), "./-o.ply");
        assert_eq!(string("a\"b\\\n"), "\"a\\\"b\\\\\\n\"");
    }
}
