use super::check::{Check, SceneProblem};
use super::parse::{options, parse};
use super::{Scene, SceneError};
use ron::ser::PrettyConfig;

impl Scene {
    /// Reads and validates a scene.
    ///
    /// # Errors
    /// [`SceneError`] with everything that is wrong, at line, column and path.
    pub fn from_ron(text: &str) -> Result<Self, SceneError> {
        let refuse = |problems| Err(SceneError { source_text: text.to_owned(), problems });
        match parse::<Self>(text) {
            Err(problem) => refuse(vec![problem]),
            Ok(scene) => {
                let problems = scene.problems(Some(text));
                if problems.is_empty() { Ok(scene) } else { refuse(problems) }
            }
        }
    }

    /// The scene as RON with all defaults filled in; it reads back as the same scene, bit for bit.
    ///
    /// # Errors
    /// [`SceneError`] if the scene is invalid.
    pub fn to_ron(&self) -> Result<String, SceneError> {
        let config = PrettyConfig::new().struct_names(false).compact_arrays(true);
        let text = options().to_string_pretty(self, config).unwrap_or_default() + "\n";
        Self::from_ron(&text).map(|_| text)
    }

    /// Validates a scene that was not read from a text.
    ///
    /// # Errors
    /// [`SceneError`] with all problems.
    pub fn validate(&self) -> Result<(), SceneError> {
        let problems = self.problems(None);
        let source_text = String::new();
        if problems.is_empty() { Ok(()) } else { Err(SceneError { source_text, problems }) }
    }

    fn problems(&self, text: Option<&str>) -> Vec<SceneProblem> {
        let mut check = Check::default();
        self.check(&mut check);
        check.finish(text)
    }
}
