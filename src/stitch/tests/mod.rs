mod cases;
mod shapes;
