//! Dispatch between the instances for two and three dimensions.
//!
//! Generic code is compiled again in every crate that uses it, with everything it calls: here the whole step. A function that
//! is not generic is compiled once.

use std::any::Any;

/// Calls `two` or `three`, whichever takes the type of `input`, and returns its result. They should not be inlined.
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
