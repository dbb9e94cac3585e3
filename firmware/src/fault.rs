//! The way into the handler of a fault of the core.

/// Makes `HardFault` go to `$handler`, an `extern "C" fn() -> !`, on a stack that begins anew.
///
/// An access without an address, an instruction without a meaning, a stack that has run out of its memory: nothing is trusted but the
/// registers, and nothing returns from here. `_stack_start` is the end of the stack's memory, as the linker's script has it
/// (cortex-m-rt); its own entry would push onto the stack that may be what is at fault. One for each image.
#[macro_export]
macro_rules! hard_fault {
    ($handler:path) => {
        core::arch::global_asm!(
            ".section .HardFault.user, \"ax\", %progbits",
            ".global HardFault",
            ".type HardFault, %function",
            ".thumb_func",
            "HardFault:",
            "ldr r0, =_stack_start",
            "mov sp, r0",
            "bl {fault}",
            "udf #0",
            ".ltorg",
            ".size HardFault, . - HardFault",
            fault = sym $handler,
        );
    };
}
