//! From the command to the winding's terminals: delay, dead zone, battery, bridge.

/// What the driver does beside passing the command on; zeros pass it on.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Driver {
    /// The command acts so much later, s.
    pub delay_s: f64,
    /// Voltage lost forwards and backwards below which nothing comes, V.
    pub dead_v: [f64; 2],
    /// Drop of the switches at large current, V, and the current over which it comes up, A.
    pub drop: (f64, f64),
    /// Battery and leads, ohm; time constant of the buffer capacitor, s.
    pub source: (f64, f64),
    /// Fall of the battery's own voltage per second, as a share.
    pub discharge: f64,
    /// Share of the PWM's off part that floats, and its frequency, Hz.
    pub coast: (f64, f64),
    /// Frequency of a PWM whose off part leaves the current to one diode, Hz, and the diode's drop, V; none where zero.
    pub freewheel: (f64, f64),
    /// Current limit of the driver, A; none where zero.
    pub limit_a: f64,
    /// Exponent of a duty curve `|d|^p`; straight where zero.
    pub curve: f64,
}

/// The driver's state in one record.
#[derive(Debug, Clone, Default)]
pub struct Bridge {
    sag_v: f64,
    carrier: f64,
    seconds: f64,
}

/// Terminals for one step.
pub struct Terminals {
    /// Voltage, V.
    pub volts: f64,
    /// Diodes alone carry the current: none flows once it has died ...
    pub floating: bool,
    /// ... except in this direction (1 or -1), which the back-EMF may start; none where zero.
    pub diode: f64,
}

/// Forward voltage of two diodes, V.
const DIODES_V: f64 = 1.5;

impl Bridge {
    /// The terminals' voltage for a command of `asked` volts at the full supply `full_v`, at the current `i`.
    pub fn step(&mut self, law: &Driver, asked: f64, full_v: f64, i: f64, dt: f64) -> Terminals {
        self.seconds += dt;
        let dead = law.dead_v[usize::from(asked < 0.0)];
        let after = asked.signum() * (asked.abs() - dead).max(0.0);
        let mut duty = (after / full_v).clamp(-1.0, 1.0);
        if law.curve > 0.0 {
            duty = duty.signum() * duty.abs().powf(law.curve);
        }
        let open_v = full_v * (1.0 - law.discharge * self.seconds);
        if law.source.0 > 0.0 {
            let target = law.source.0 * (duty * i).max(-0.05 * i.abs());
            self.sag_v += (target - self.sag_v) * (dt / law.source.1).min(1.0);
        }
        let bus = open_v - self.sag_v;
        let drop = if law.drop.0 > 0.0 {
            i.signum() * law.drop.0 * (1.0 - (-i.abs() / law.drop.1).exp())
        } else {
            0.0
        };
        if law.freewheel.0 > 0.0 {
            let (hertz, diode_v) = law.freewheel;
            let on = self.on(duty, dt * hertz);
            // At zero duty both sides are off, and the current goes on as it was.
            let way = if duty == 0.0 { i.signum() } else { duty.signum() };
            let off_v = if i * way < 0.0 { bus + DIODES_V } else { -diode_v };
            return Terminals {
                volts: way * (on * bus + (1.0 - on) * off_v) - drop,
                floating: on < 0.5,
                diode: if duty == 0.0 { 0.0 } else { way },
            };
        }
        if law.coast.0 == 0.0 {
            return Terminals { volts: duty * bus - drop, floating: false, diode: 0.0 };
        }
        let on = self.on(duty, dt * law.coast.1);
        let floats =
            self.carrier > duty.abs() && self.carrier < duty.abs() + law.coast.0 * (1.0 - duty.abs());
        let off_v = if floats && i.abs() > 1e-9 { -i.signum() * (bus + DIODES_V) } else { 0.0 };
        Terminals {
            volts: on * duty.signum() * bus + (1.0 - on) * off_v - drop,
            floating: floats && on < 0.5,
            diode: 0.0,
        }
    }

    /// Share of the next step, `periods` of the PWM long, that is driven.
    fn on(&mut self, duty: f64, periods: f64) -> f64 {
        self.carrier = (self.carrier + periods).fract();
        ((duty.abs() - (self.carrier - periods)) / periods).clamp(0.0, 1.0)
    }
}
