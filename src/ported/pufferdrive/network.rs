use super::Observation;

/// Numbers of an encoding, and of the state.
const ENCODING: usize = 64;
const STATE: usize = 256;
/// Bytes of a file.
const SIZE: usize = 4 * 614_172;
/// Where the weights are.
pub const ORIGIN: &str = "fetch `pufferlib/resources/drive/puffer_drive_weights_carla_town12.bin` from the GitHub repository \
     `Emerge-Lab/Adaptive_Driving_Agent` at 28a233c8ae51eb10adeb3d0e1dbfc431ee1838f3 (2,456,688 bytes, sha256 \
     bdd7bffb5ab37c03f3727448b83d6727df544eccc798f22233964276818e1022)";
/// The BLAKE3 digest of the published weights.
pub const BLAKE3: &str = "69923824f23493dda42bca52695d19a2ae70a5cb19e415900458682b13c99e58";

/// The network: three encoders, the greatest numbers of the encodings of all rows, a hidden layer, an LSTM, the logits of 91 actions.
///
/// Matrices have the shape (inputs, outputs): each sum is taken in the order of the inputs, so its bits are the same on every processor, and
/// those of neighbouring outputs are taken at once.
#[derive(Debug)]
pub struct Network(Vec<f32>);

/// Weights that are not taken yet.
#[derive(Clone, Copy)]
struct Rest<'a>(&'a [f32]);

impl<'a> Rest<'a> {
    fn take(&mut self, count: usize) -> &'a [f32] {
        let (first, rest) = self.0.split_at(count);
        self.0 = rest;
        first
    }

    fn multiply(&mut self, inputs: &[f32], outputs: &mut [f32]) {
        let matrix = self.take(inputs.len() * outputs.len());
        for (input, weights) in inputs.iter().zip(matrix.chunks_exact(outputs.len())) {
            outputs.iter_mut().zip(weights).for_each(|(output, weight)| *output += input * weight);
        }
    }

    fn add(&mut self, outputs: &mut [f32]) {
        let bias = self.take(outputs.len());
        outputs.iter_mut().zip(bias).for_each(|(output, bias)| *output += bias);
    }

    /// The greatest numbers of rows after linear, layer norm and linear.
    fn encode<const N: usize>(&mut self, rows: impl Iterator<Item = [f32; N]>) -> [f32; ENCODING] {
        let mut greatest = [f32::NEG_INFINITY; ENCODING];
        let weights = Self(self.take(ENCODING * (N + 3 + ENCODING + 1)));
        for row in rows {
            let (mut weights, mut inner, mut encoding) = (weights, [0.0; ENCODING], [0.0; ENCODING]);
            weights.multiply(&row, &mut inner);
            weights.add(&mut inner);
            let mean = inner.iter().sum::<f32>() / ENCODING as f32;
            let variance = inner.iter().map(|number| (number - mean) * (number - mean)).sum::<f32>() / ENCODING as f32;
            let (scale, gain) = (1.0 / (variance + 1e-5).sqrt(), weights.take(ENCODING));
            inner.iter_mut().zip(gain).for_each(|(number, gain)| *number = (*number - mean) * scale * gain);
            weights.add(&mut inner);
            weights.multiply(&inner, &mut encoding);
            weights.add(&mut encoding);
            greatest.iter_mut().zip(encoding).for_each(|(greatest, number)| *greatest = greatest.max(number));
        }
        greatest
    }
}

impl Network {
    /// Reads a file: little-endian 32-bit floats without a header. The bound of the weights keeps all that is computed finite.
    ///
    /// # Errors
    /// It has another size, or a number is not a weight; as a part of a sentence.
    pub fn read(bytes: &[u8]) -> Result<Self, String> {
        if bytes.len() != SIZE {
            let is_pointer = bytes.starts_with(b"version https://git-lfs");
            let why = if is_pointer { ": it is a pointer of Git LFS and not the file itself" } else { "" };
            return Err(format!("it has {} bytes instead of {}{why}", bytes.len(), SIZE));
        }
        let numbers: Vec<f32> = bytes.as_chunks().0.iter().map(|four| f32::from_le_bytes(*four)).collect();
        if let Some(place) = numbers.iter().position(|number| !(-1e3..=1e3).contains(number)) {
            return Err(format!("its number {place} is {} and not between -1000 and 1000", numbers[place]));
        }
        let encoder = |inputs| [(64, inputs), (3 * 64, 1), (64, 64), (64, 1)];
        let others = [(256, 192), (256, 1), (91, 256), (91 + 257, 1), (1024, 256), (1024, 256), (2048, 1)];
        let (mut rest, mut weights) = (Rest(&numbers), Vec::with_capacity(numbers.len()));
        for (outputs, inputs) in [encoder(7), encoder(13), encoder(7)].into_iter().flatten().chain(others) {
            let matrix = rest.take(outputs * inputs);
            weights.extend((0..matrix.len()).map(|at| matrix[at % outputs * inputs + at / outputs]));
        }
        Ok(Self(weights))
    }

    /// The logits of all actions; the state, h and c, goes on. Rows that an observation lacks are zeros, and take part.
    pub fn step(&self, observation: &Observation, [hidden, cell]: &mut [[f32; STATE]; 2]) -> [f32; 91] {
        let Observation { ego, others, road } = observation;
        let zeros = |rows: &[[f32; 7]], all: usize| (rows.len() < all).then_some([0.0; 7]);
        let others = others.iter().copied().chain(zeros(others, 63));
        let road = road.iter().copied().chain(zeros(road, 200)).map(|row| {
            let kind = 6 + row[6] as usize;
            std::array::from_fn::<_, 13, _>(|at| if at < 6 { row[at] } else { f32::from(u8::from(at == kind)) })
        });
        let mut rest = Rest(&self.0);
        let mut encodings = [rest.encode(std::iter::once(*ego)), rest.encode(road), rest.encode(others)];
        // The form of GELU with tanh, as in the C code; training had the one with erf.
        let gelu = |x: f32| 0.5 * x * (1.0 + libm::tanhf(0.797_884_6 * (x + 0.044_715 * x * x * x)));
        encodings.as_flattened_mut().iter_mut().for_each(|number| *number = gelu(*number));
        let (mut mixed, mut logits, mut gates) = ([0.0; STATE], [0.0; 91], [0.0; 4 * STATE]);
        rest.multiply(encodings.as_flattened(), &mut mixed);
        rest.add(&mut mixed);
        let mut actor = Rest(rest.take(91 * STATE + 91));
        // The value of a state, which drives nothing.
        rest.take(STATE + 1);
        rest.multiply(&mixed.map(|number| number.max(0.0)), &mut gates);
        rest.multiply(hidden, &mut gates);
        rest.add(&mut gates);
        rest.add(&mut gates);
        let sigmoid = |x: f32| 1.0 / (1.0 + libm::expf(-x));
        for place in 0..STATE {
            let [i, f, g, o] = [0, 1, 2, 3].map(|gate| gates[gate * STATE + place]);
            cell[place] = sigmoid(f) * cell[place] + sigmoid(i) * libm::tanhf(g);
            hidden[place] = sigmoid(o) * libm::tanhf(cell[place]);
        }
        actor.multiply(hidden, &mut logits);
        actor.add(&mut logits);
        logits
    }
}
