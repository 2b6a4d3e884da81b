use std::sync::{Arc, OnceLock};

use super::model::{ActionModel, ActionModelError};

impl ActionModel {
    /// The model that comes with the program, read once.
    ///
    /// # Errors
    /// Never for an untouched program: what [`ActionModel::from_ron`] says of a damaged file.
    pub fn bundled() -> Result<Arc<Self>, ActionModelError> {
        static READ: OnceLock<Arc<ActionModel>> = OnceLock::new();
        if let Some(model) = READ.get() {
            return Ok(model.clone());
        }
        let model = Arc::new(Self::from_ron(include_str!("../../../assets/actions/actions.ron"))?);
        Ok(READ.get_or_init(|| model).clone())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evolve::action::ActionKind;

    #[test]
    fn the_bundled_model_knows_every_type_of_action() {
        let model = ActionModel::bundled().expect("reads");
        for kind in ActionKind::ALL {
            assert!(model.nodes.iter().any(|n| n.kind == kind), "{}", kind.label());
        }
    }
}
