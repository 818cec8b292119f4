use safetensors::SafeTensorError;

/// Why bytes are not a checkpoint.
#[derive(Debug, thiserror::Error)]
pub enum CheckpointError {
    #[error("not a safetensors file: {0}")]
    Format(#[source] SafeTensorError),
    #[error("the tensor `{name}` is missing")]
    Missing { name: String },
    #[error("the tensor `{name}` holds {found}, not {expected}")]
    Type { name: String, expected: &'static str, found: String },
    #[error("the tensor `{name}` has the shape {found:?}, which does not fit")]
    Shape { name: String, found: Vec<usize> },
    #[error("the tensor `{name}` contains a number that is not finite")]
    NonFinite { name: String },
    #[error("the training was begun with another `{name}`")]
    Settings { name: String },
    #[error("it has {found} policies, and this training has {expected}")]
    Policies { found: usize, expected: usize },
    #[error("environment {env} does not accept its saved state")]
    Env {
        /// The number of the environment, from 0.
        env: usize,
    },
}
