// Decodes LCM messages with the types that the server tells (types.json). Big-endian; 8 bytes of fingerprint come first.
// Every count is checked against the bytes that are left, so that bytes from outside cannot make it allocate or loop without end.
import { counted } from "../words.js";

/** @typedef {{name: string, type: string, dims?: (string|number)[], comment?: string}} Field */
/** @typedef {{fingerprint: string, comment?: string, fields: Field[]}} Type */
/** @typedef {Record<string, any>} Message */
/** @typedef {{type: string, value: Message}} Decoded */
/** @typedef {(reader: Reader) => any} Decode */

/** Why bytes were not understood, in words. */
export class DecodeError extends Error {}

/** Smallest number of bytes of one value of a primitive type. */
const sizes = new Map(Object.entries({ int8_t: 1, byte: 1, boolean: 1, int16_t: 2, int32_t: 4, float: 4, int64_t: 8, double: 8, string: 5 }));
const words = new TextDecoder();

/** Where we are in a message's bytes. */
class Reader {
  /** @param {Uint8Array} bytes */
  constructor(bytes) {
    this.bytes = bytes;
    this.view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
    this.at = 0;
  }

  /** Takes `count` bytes and returns where they begin.
   * @param {number} count */
  take(count) {
    const begin = this.at;
    if (count > this.bytes.length - begin) throw new DecodeError(`ends after ${counted(this.bytes.length, "byte")}, in the middle of a value`);
    this.at = begin + count;
    return begin;
  }
}

/** @type {Record<string, Decode>} */
const primitives = {
  int8_t: (r) => r.view.getInt8(r.take(1)),
  byte: (r) => r.view.getUint8(r.take(1)),
  boolean: (r) => r.view.getUint8(r.take(1)) !== 0,
  int16_t: (r) => r.view.getInt16(r.take(2)),
  int32_t: (r) => r.view.getInt32(r.take(4)),
  float: (r) => r.view.getFloat32(r.take(4)),
  double: (r) => r.view.getFloat64(r.take(8)),
  // A number where that is exact, else a bigint: run ids are 64 random bits.
  int64_t: (r) => {
    const begin = r.take(8);
    const high = r.view.getInt32(begin);
    if (high >= -0x200000 && high < 0x200000) return high * 4294967296 + r.view.getUint32(begin + 4);
    return r.view.getBigInt64(begin);
  },
  string: (r) => {
    const length = r.view.getUint32(r.take(4));
    if (length < 1) throw new DecodeError("contains an unterminated string");
    const begin = r.take(length);
    return words.decode(r.bytes.subarray(begin, begin + length - 1));
  },
};

/** The message types of a server. */
export class Types {
  /** @param {{types: Record<string, Type>, channels?: Record<string, string>}} json */
  constructor(json) {
    this.types = json.types;
    this.channels = json.channels ?? {};
    /** @type {Map<string, string>} */
    this.names = new Map(Object.entries(json.types).map(([name, type]) => [type.fingerprint.toLowerCase(), name]));
    /** @type {Map<string, Decode>} */
    this.decoders = new Map();
  }

  /** The type's name of these bytes, or undefined when it is none of ours.
   * @param {Uint8Array} bytes */
  name_of(bytes) {
    if (bytes.length < 8) return undefined;
    let fingerprint = "";
    for (let i = 0; i < 8; ++i) fingerprint += bytes[i].toString(16).padStart(2, "0");
    return this.names.get(fingerprint);
  }

  /** Throws DecodeError.
   * @param {Uint8Array} bytes @returns {Decoded} */
  decode(bytes) {
    const type = this.name_of(bytes);
    if (type === undefined) throw new DecodeError("has a type unknown to this server");
    scopes = [];
    const reader = new Reader(bytes);
    reader.take(8);
    const value = this.decoder(type)(reader);
    if (reader.at !== bytes.length) throw new DecodeError(`has ${counted(bytes.length - reader.at, "byte")} too many`);
    return { type, value };
  }

  /** @param {string} name @returns {Decode} */
  decoder(name) {
    if (primitives[name]) return primitives[name];
    // A field's type may have its package's name before its own.
    const bare = this.types[name] ? name : name.slice(name.lastIndexOf(".") + 1);
    let decode = this.decoders.get(bare);
    if (!decode) {
      const type = this.types[bare];
      if (!type) throw new DecodeError(`contains a ${name}, a type unknown to the server`);
      const fields = type.fields.map((f) => /** @type {[string, Decode]} */ ([f.name, this.field_decoder(f)]));
      decode = (reader) => {
        /** @type {Message} */
        const message = {};
        scopes.push(message);
        for (const [field, read] of fields) message[field] = read(reader);
        scopes.pop();
        return message;
      };
      this.decoders.set(bare, decode);
    }
    return decode;
  }

  /** @param {Field} field @returns {Decode} */
  field_decoder(field) {
    const element = this.decoder(field.type);
    const smallest = sizes.get(field.type) ?? 1;
    const dims = field.dims ?? [];
    if (field.type === "byte" && dims.length === 1) {
      return (reader) => {
        const length = count(dims[0], reader, 1);
        const begin = reader.take(length);
        return reader.bytes.slice(begin, begin + length);
      };
    }
    return dims.reduceRight((/** @type {Decode} */ inner, dim) => {
      return (reader) => {
        const n = count(dim, reader, smallest);
        const list = new Array(n);
        for (let i = 0; i < n; ++i) list[i] = inner(reader);
        return list;
      };
    }, element);
  }
}

/** @type {Message[]} Messages that are being read, the innermost last: a count is a field of the one that holds the array. */
let scopes = [];

/** @param {string|number} dim @param {Reader} reader @param {number} smallest */
function count(dim, reader, smallest) {
  const n = typeof dim === "number" ? dim : /^\d+$/.test(dim) ? Number(dim) : scopes[scopes.length - 1][dim];
  if (!Number.isInteger(n) || n < 0 || n * smallest > reader.bytes.length - reader.at) {
    throw new DecodeError(`says that ${dim} is ${n}, more than its bytes can hold`);
  }
  return n;
}
