//! A URDF joint's limits and dynamics, and its ros2_control block.
//!
//! `effort` and `velocity` are stall torque and no-load speed at the nominal voltage, `damping` the viscous friction, `friction` the
//! dry one. URDF has no armature: Gazebo and others take the rotor's inertia from a link. ros2_control loads no component without
//! a driver; its own mock, which returns every command as the state, stands in the driver's place. Sources: the URDF specification of
//! a joint, ros2_control's hardware components.

use motorlens_shared::effects::Kind;

use super::actuator::{LOADS, OF_THE_ROBOT, leave, one_level, take};
use super::{Exported, Format, Options, xml};
use crate::error::Result;
use crate::model_file::Model;

const TAKEN: [Kind; 4] = [Kind::Coulomb, Kind::ConstantLoad, Kind::Gravity, Kind::Spring];

/// Two elements to paste into a robot's description.
pub(super) fn export(model: &Model, options: &Options) -> Result<Exported> {
    let scale = options.torque(Format::Urdf)?;
    let (a, lost, carried) = take(model, &TAKEN, "a URDF joint has limits, damping and one friction only");
    let b = &model.base;
    let volts = model.rig.nominal_v;
    // At the no-load speed, damping takes what back-EMF leaves.
    let voltage = format!(
        "The joint follows a torque. For a voltage u command effort = {scale:.6e} * u - {:.6e} * speed.",
        scale * b.base().back_emf()
    );
    let notes = vec![
        format!(
            "URDF has no armature: give the link {:.4e} kg m^2 about the joint's axis.",
            scale * b.tau_m / b.gain
        ),
        voltage.clone(),
    ];
    let left = leave(model, &LOADS, OF_THE_ROBOT);
    let text = format!(
        r#"<robot name="motorlens">
  <!-- Written by motorlens. Output shaft at {volts} V; rotor and gear seen there: {armature:.6e} kg m^2.
       {voltage} -->
  <link name="base"/>
  <link name="shaft"/>
  <joint name="{name}" type="continuous">
    <parent link="base"/>
    <child link="shaft"/>
    <axis xyz="0 0 1"/>
    <limit effort="{stall:.9}" velocity="{no_load:.9}"/>
    <dynamics damping="{viscous:.9}" friction="{friction:.9}"/>
  </joint>
  <ros2_control name="motor" type="system">
    <hardware>
      <!-- A mock, in the place of your driver's plugin. -->
      <plugin>mock_components/GenericSystem</plugin>
    </hardware>
    <joint name="{name}">
      <command_interface name="effort">
        <param name="min">-{stall:.9}</param>
        <param name="max">{stall:.9}</param>
      </command_interface>
      <command_interface name="velocity">
        <param name="min">-{no_load:.9}</param>
        <param name="max">{no_load:.9}</param>
      </command_interface>
      <state_interface name="position"/>
      <state_interface name="velocity"/>
    </joint>
  </ros2_control>
</robot>
"#,
        armature = scale * b.tau_m / b.gain,
        name = xml(options.name.as_deref().unwrap_or("output")),
        stall = scale * volts,
        no_load = b.gain * volts,
        viscous = scale * b.viscous_share / b.gain,
        friction = scale * a.friction,
    );
    let carried = one_level(carried, a.friction, &[]);
    Ok(Exported::numbers(text, carried, notes, lost, left))
}
