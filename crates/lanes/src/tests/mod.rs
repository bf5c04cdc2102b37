mod composites;
mod operations;
mod widths;
