mod cases;
mod input;
pub mod shapes;
