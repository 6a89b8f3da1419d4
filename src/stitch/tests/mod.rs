mod cases;
pub mod shapes;
