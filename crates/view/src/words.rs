//! Steps as commands of the command line.

use isomend_files::job::Work;

/// The option that leaves patches across seams of a texture without texels of their own.
pub const NO_TEXTURE: &str = "no-texture";

/// A command with its options, without its input and output files.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Command {
    /// Its name.
    pub name: String,
    /// Its options: long names without dashes, and values; none for flags.
    pub options: Vec<(String, Option<String>)>,
}

impl Command {
    /// A command without options.
    pub fn new(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            options: Vec::new(),
        }
    }

    /// Adds an option with a value.
    pub fn option(&mut self, name: &str, value: impl ToString) {
        let value = Some(value.to_string());
        self.options.push((name.to_owned(), value));
    }

    /// Changes the value of an option that the command has.
    pub fn set(&mut self, name: &str, value: String) {
        let mut options = self.options.iter_mut();
        if let Some((_, old)) = options.find(|(option, _)| option == name) {
            *old = Some(value);
        }
    }

    /// Whether the command has an option.
    pub fn has(&self, name: &str) -> bool {
        self.options.iter().any(|(option, _)| option == name)
    }

    /// Adds an option without a value.
    pub fn flag(&mut self, name: &str) {
        self.options.push((name.to_owned(), None));
    }

    /// The options as arguments. A value that begins with a dash is joined to its name.
    pub fn arguments(&self) -> Vec<String> {
        let mut arguments = Vec::new();
        for (name, value) in &self.options {
            match value {
                Some(value) if value.starts_with('-') => {
                    arguments.push(format!("--{name}={value}"));
                }
                Some(value) => arguments.extend([format!("--{name}"), value.clone()]),
                None => arguments.push(format!("--{name}")),
            }
        }
        arguments
    }

    /// The name and the options.
    pub fn words(&self) -> Vec<String> {
        let mut words = vec![self.name.clone()];
        words.extend(self.arguments());
        words
    }
}

/// Writes steps as commands. The command line, which defines the names of commands and options, implements it.
pub trait CommandRenderer: Send + Sync {
    /// The command that does `work`; `faces` is the file of face numbers of its mask.
    ///
    /// # Errors
    /// When the command line refuses the work or cannot express it.
    fn command(&self, work: &Work, faces: Option<&str>) -> Result<Command, String>;
}
