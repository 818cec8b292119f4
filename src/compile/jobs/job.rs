use std::any::Any;

use super::{Cover, Estimation, Evaluation, Harden, Origin, Originated, Planned, Pricing, Search, Training};

macro_rules! kinds {
    ($($kind:ident),*) => {
        /// A job of a campaign.
        #[derive(Debug, Clone)]
        pub enum Job {
            $($kind($kind)),*
        }

        impl Job {
            /// What all kinds have in common.
            pub fn planned(&self) -> &dyn Planned {
                match self {
                    $(Self::$kind(job) => job),*
                }
            }

            pub(crate) fn planned_mut(&mut self) -> &mut dyn Planned {
                match self {
                    $(Self::$kind(job) => job),*
                }
            }

            pub(crate) fn origin_mut(&mut self) -> &mut Origin {
                match self {
                    $(Self::$kind(job) => &mut job.origin),*
                }
            }
        }

        $(impl Originated for $kind {
            fn origin(&self) -> &Origin {
                &self.origin
            }
        }

        impl From<$kind> for Job {
            fn from(job: $kind) -> Self {
                Self::$kind(job)
            }
        })*
    };
}

kinds!(Training, Evaluation, Search, Estimation, Cover, Harden, Pricing);

impl Job {
    pub fn origin(&self) -> &Origin {
        self.planned().origin()
    }

    /// The job, if it is of this kind.
    pub fn of<T: Planned>(&self) -> Option<&T> {
        (self.planned() as &dyn Any).downcast_ref()
    }
}
