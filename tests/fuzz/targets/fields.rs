//! The fields of wire structures in one order, from bytes and back: one description for both.

use ambidex::link::wire::{WireBeat, WireId, WireName, WirePulse, WireReport, WireRequest, WireResponse, WireState};

/// What fills fields from bytes, or writes them down.
pub trait Fields {
    fn bytes(&mut self, field: &mut [u8]);

    fn u32(&mut self, field: &mut u32) {
        let mut bytes = field.to_le_bytes();
        self.bytes(&mut bytes);
        *field = u32::from_le_bytes(bytes);
    }

    fn u64(&mut self, field: &mut u64) {
        let mut bytes = field.to_le_bytes();
        self.bytes(&mut bytes);
        *field = u64::from_le_bytes(bytes);
    }

    fn f64(&mut self, field: &mut f64) {
        let mut bytes = field.to_le_bytes();
        self.bytes(&mut bytes);
        *field = f64::from_le_bytes(bytes);
    }

    fn id(&mut self, id: &mut WireId) {
        self.u64(&mut id.epoch);
        self.u32(&mut id.generation);
        self.u32(&mut id.number);
    }

    fn name(&mut self, name: &mut WireName) {
        self.u32(&mut name.len);
        self.bytes(&mut name.text);
    }

    fn state(&mut self, state: &mut WireState) {
        self.u32(&mut state.kind);
        self.name(&mut state.holds);
        let numbers = state.position.iter_mut().chain(&mut state.velocity);
        numbers.for_each(|number| self.f64(number));
    }

    fn request(&mut self, wire: &mut WireRequest) {
        [&mut wire.version, &mut wire.kind].into_iter().for_each(|field| self.u32(field));
        self.id(&mut wire.id);
        self.u64(&mut wire.origin_ns);
        self.f64(&mut wire.speed);
        self.state(&mut wire.start);
        [&mut wire.mode, &mut wire.command].into_iter().for_each(|field| self.u32(field));
        [&mut wire.object, &mut wire.place, &mut wire.call, &mut wire.holder]
            .into_iter()
            .for_each(|name| self.name(name));
        [&mut wire.path_len, &mut wire.with_len].into_iter().for_each(|field| self.u32(field));
        self.f64(&mut wire.takes);
        wire.at.iter_mut().chain(&mut wire.limits).for_each(|number| self.f64(number));
        for pose in &mut wire.path {
            [&mut pose.x, &mut pose.y, &mut pose.heading].into_iter().for_each(|number| self.f64(number));
        }
        self.bytes(&mut wire.with);
    }

    fn response(&mut self, wire: &mut WireResponse) {
        [&mut wire.version, &mut wire.kind].into_iter().for_each(|field| self.u32(field));
        self.id(&mut wire.id);
        let codes = [&mut wire.why, &mut wire.end, &mut wire.inhibited, &mut wire.reserved];
        codes.into_iter().for_each(|field| self.u32(field));
        self.f64(&mut wire.progress);
        [&mut wire.began_us, &mut wire.ended_us].into_iter().for_each(|field| self.u64(field));
        self.state(&mut wire.state);
    }

    fn pulse(&mut self, wire: &mut WirePulse) {
        [&mut wire.version, &mut wire.pid].into_iter().for_each(|field| self.u32(field));
        self.u64(&mut wire.epoch);
        [&mut wire.generation, &mut wire.inhibited].into_iter().for_each(|field| self.u32(field));
        [&mut wire.sent_ns, &mut wire.at_us].into_iter().for_each(|field| self.u64(field));
        self.state(&mut wire.state);
    }

    fn beat(&mut self, wire: &mut WireBeat) {
        [&mut wire.version, &mut wire.pid].into_iter().for_each(|field| self.u32(field));
        [&mut wire.epoch, &mut wire.sent_ns].into_iter().for_each(|field| self.u64(field));
    }

    fn report(&mut self, wire: &mut WireReport) {
        [&mut wire.version, &mut wire.kind].into_iter().for_each(|field| self.u32(field));
        self.id(&mut wire.id);
        [&mut wire.holds, &mut wire.reserved].into_iter().for_each(|field| self.u32(field));
        [&mut wire.name, &mut wire.place].into_iter().for_each(|name| self.name(name));
    }
}

/// Bytes that become fields; where they end, fields stay as they are.
pub struct From<'a>(pub &'a [u8]);

impl Fields for From<'_> {
    fn bytes(&mut self, field: &mut [u8]) {
        if let Some((bytes, rest)) = self.0.split_at_checked(field.len()) {
            field.copy_from_slice(bytes);
            self.0 = rest;
        } else {
            self.0 = &[];
        }
    }
}

/// Fields that become bytes.
pub struct Into(pub Vec<u8>);

impl Fields for Into {
    fn bytes(&mut self, field: &mut [u8]) {
        self.0.extend_from_slice(field);
    }
}
