//! The macro that generates the builder-style setters of parameter structs.

/// Generates `new` and one setter a line for a struct of parameters: name and argument, then the field and its new value. A setter
/// takes the struct by value and returns it.
macro_rules! setters {
    ($params:ty: $(
        $(#[$doc:meta])*
        $name:ident($argument:ident: $type:ty) => $field:ident = $value:expr;
    )*) => {
        impl $params {
            /// The defaults.
            pub fn new() -> Self {
                Self::default()
            }

            $(
                $(#[$doc])*
                #[must_use]
                pub fn $name(mut self, $argument: $type) -> Self {
                    self.$field = $value;
                    self
                }
            )*
        }
    };
}
pub(crate) use setters;
