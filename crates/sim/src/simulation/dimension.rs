//! Code for two and for three dimensions, compiled here.
//!
//! What is generic is compiled anew in every crate that uses it, and with it all that it calls: the whole step, many times.
//! A function that is not generic is compiled once.

use std::any::Any;

/// What `two` or `three` gives back for `input`, whichever takes it. They should not be inlined.
pub fn by_dimension<A, I: Any, O: Any, I2: Any, O2: Any, I3: Any, O3: Any>(
    input: &mut I,
    arguments: A,
    two: fn(&mut I2, A) -> O2,
    three: fn(&mut I3, A) -> O3,
) -> O {
    let mut output: Option<O> = None;
    let input: &mut dyn Any = input;
    if let Some(input) = input.downcast_mut() {
        put(two(input, arguments), &mut output);
    } else if let Some(input) = input.downcast_mut() {
        put(three(input, arguments), &mut output);
    }
    let Some(output) = output else { unreachable!("two dimensions or three") };
    output
}

fn put<T: Any, O: Any>(value: T, output: &mut Option<O>) {
    let output: &mut dyn Any = output;
    if let Some(output) = output.downcast_mut() {
        *output = Some(value);
    }
}
